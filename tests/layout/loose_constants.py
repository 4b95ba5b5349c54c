#!/usr/bin/env python3
"""No number with a name decides in the diagnosis outside its settings.

Usage: loose_constants.py ROOT
Reads tools/diagnose and fails on every constant that holds a number (constexpr, or const with a literal; in a file, a
class or a function) unless KEPT names it with a reason: what is no choice (a law, a format, a size that memory
needs), and what is only shown. What changes an answer belongs to tools/diagnose/settings*.h, with unit and range.
"""
import pathlib
import re
import sys

HOUSE = "tools/diagnose"
SETTINGS = re.compile(rf"{HOUSE}/settings\w*\.h$")
# (file below tools/diagnose, name): why it is no setting.
KEPT = {
    ("effects/effect.h", "kOff"): "a mark for 'not switched on' that files hold: compared for equality, never scaled",
    ("effects/whole_figures.h", "kJointFigures"): "members of the enumeration above it",
    ("explain/chance.cpp", "kStream"): "names a stream of random draws",
    ("explain/polling.cpp", "kStream"): "names a stream of random draws",
    ("explain/rivals.h", "kNoiseUnit"): "two units of energy are one of log-likelihood",
    ("explain/whole_time.cpp", "kSeed"): "names a stream of random draws",
    ("fit/fit.h", "kGainMeasures"): "how many measures the comparison has",
    ("fit/heldout_gain.cpp", "kSeed"): "names a stream of random draws",
    ("fit/heldout_gain.cpp", "kUnit"): "two units of energy are one of log-likelihood",
    ("torque/columns.cpp", "kTold"): "how many readings a person is told",
    ("fit/normal_equations.h", "kWhisper"): "keeps a matrix regular: far below what any row says of a number",
    ("fit/screen.cpp", "kEdge"): "rounding, where a nuisance stands at its bound",
    ("fit/screen.cpp", "kRounding"): "rounding of a sum of squares, far below any noise",
    ("formats/lost.cpp", "kUsual"): "the gravity that a format means when it says none",
    ("formats/parts.cpp", "kUpright"): "rounding of an angle, where roll and yaw turn about one axis",
    ("formats/sdf.cpp", "kLeastInertia_kgm2"): "the format refuses zero",
    ("formats/sdf.cpp", "kLeastMass_kg"): "the format refuses zero",
    ("formats/urdf.cpp", "kMany"): "the format demands a number where the model has none",
    ("gate/checks.h", "kDegree"): "a unit",
    ("model_folder/body_tree.h", "kMaxBodyJoints"): "size of memory",
    ("model_folder/robot_tree.h", "kIdentity3"): "a unit matrix",
    ("model_folder/robot_tree.h", "kMaxJoints"): "size of memory",
    ("model_folder/whole_body.cpp", "kHardest"): "range of a figure that a person writes; what is outside is refused",
    ("model_folder/whole_body.cpp", "kSoftest"): "range of a figure that a person writes; what is outside is refused",
    ("run/planner_model.cpp", "kSoleThickness"): "of a sole as it is drawn: the lower face, which touches, is the model's",
    ("run/report_proof.cpp", "kRows"): "rows that a table shows",
    ("run/score.cpp", "kSeconds"): "the horizons that a score is defined by; kHorizonNames says them",
    ("run/session_recordings.cpp", "kNoPose"): "a mark in a stored session",
    ("run/shown.cpp", "kShotsShown"): "what a page shows",
    ("run/shown_motion.cpp", "kFloatingShotSeconds"): "what a page shows",
    ("run/shown_motion.cpp", "kMostNumbers"): "what a page shows",
    ("run/shown_motion.cpp", "kRowSeconds"): "what a page shows",
    ("run/shown_motion.cpp", "kShotSeconds"): "what a page shows",
    ("run/time_ahead.cpp", "kColumns"): "how long a run may take is said with it, nothing else",
    ("run/time_ahead.cpp", "kSteps"): "how long a run may take is said with it, nothing else",
    ("sim/command_path.h", "kUnset"): "a mark",
    ("sim/integrator.h", "kUnknown"): "a mark",
    ("sim/lane_clocks.h", "kRounding"): "rounding of an instant",
    ("sim/lane_math.h", "kLanes"): "lanes of a plain number",
    ("sim/transmission_step.h", "kSlipElements"): "the law of an effect, written for four: its states and shares",
    ("sim/window_run.h", "kAll"): "a mark",
    ("stats/robust.h", "kSigmaOfMedian"): "a figure of the normal distribution",
    ("stats/significance.h", "kNormal95"): "quantile of the normal distribution",
    ("stats/significance.cpp", "z"): "quantile of the normal distribution",
    ("torque/bounded_least_squares.cpp", "kRidge"): "of rounding: moves nothing that data determine",
    ("torque/effort_terms.cpp", "kAngleStep"): "step of a difference quotient",
    ("torque/effort_terms.cpp", "kLengthStep"): "step of a difference quotient of what is linear",
    ("verdict/plain_words.cpp", "kListed"): "places that a sentence tells",
    ("verdict/plain_words.cpp", "kTold"): "sentences that a page tells",
    ("verdict/remains.cpp", "kTorqueStream"): "names a stream of random draws",
    ("verdict/remains.cpp", "kVelocityStream"): "names a stream of random draws",
    ("wholebody/base_checks.cpp", "kGravity"): "standard gravity, which tells g from m/s^2",
    ("wholebody/drive_rows.cpp", "kStep"): "step of a difference quotient",
    ("wholebody/soles_apart.cpp", "kStep"): "step of a difference quotient",
    ("wholebody/known.cpp", "kMost"): "keeps the number of a group an integer: a day in pieces of a second",
    ("wholebody/roll_out.cpp", "kFrictionUnstated"): "of the motion that a page shows; a verdict asks no roll-out",
    ("wholebody/roll_out.cpp", "kHalfWindow"): "what a page shows",
    ("wholebody/roll_out.cpp", "kPushedOut"): "what a page shows",
    ("wholebody/roll_out.cpp", "kRebounds_m_s"): "what a page shows",
    ("wholebody/roll_out.cpp", "kRows"): "what a page shows",
    ("wholebody/roll_out.cpp", "kStep_s"): "what a page shows",
    ("wholebody/roll_out.cpp", "kSweeps"): "what a page shows",
    ("wholebody/roll_out.cpp", "kTouches_m"): "what a page shows",
}
TYPE = r"(?:std::)?(?:double|float|int|unsigned|long|auto|size_t|u?int(?:8|16|32|64)_t|Vec3|V3|Mat3|array<[^;={}]*>)"
# Of `const` only what begins with a literal: other locals are calculated.
DECLARED = re.compile(
    rf"(?:\bconstexpr\s+(?:const\s+)?{TYPE}(?:\s+const)?|\bconst\s+{TYPE})\s+(\w+\s*(?:=|\{{)[^;]*);")
NAMED = re.compile(r"(?:^|,)\s*(\w+)\s*(?:=\s*|(?=\{))([^,{]*(?:\{[^}]*\})?[^,]*)", re.S)
CONSTEXPR = re.compile(r"\bconstexpr\b")
LITERAL = re.compile(r"^\{?\s*-?\.?\d[\w.+\-']*\s*\}?$")
# Infinity and "not a number" are no figures; what another constant or a type gives is decided there.
NO_FIGURE = re.compile(r"numeric_limits|::kLanes\b")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
TEXT = re.compile(r'"(?:[^"\\\n]|\\.)*"')


def blank(match):
    """Keeps lines where they are."""
    return re.sub(r"[^\n]", " ", match.group())


def constants(text):
    """[(line, name)] of the constants that hold a number."""
    text = COMMENT.sub(blank, TEXT.sub(lambda m: '"' + " " * (len(m.group()) - 2) + '"', text))
    found = []
    at = 0
    while declared := DECLARED.search(text, at):  # one may hold another: a lambda that is const
        at = declared.start() + 1
        fixed = CONSTEXPR.match(text, declared.start())
        for name, value in NAMED.findall(declared.group(1)):
            value = value.strip()
            alone = LITERAL.match(value)
            if alone or (fixed and not re.fullmatch(r"-?[A-Za-z_]\w*", value) and '"' not in value
                         and not (NO_FIGURE.search(value) and "{" not in value)):
                found.append((text.count("\n", 0, declared.start()) + 1, name))
    return found


def complaints(files, kept):
    """files: {path from the root: text}."""
    seen = set()
    for path, text in sorted(files.items()):
        if SETTINGS.search(path):
            continue
        for line, name in constants(text):
            key = (path.removeprefix(HOUSE + "/"), name)
            seen.add(key)
            if key not in kept:
                yield f"{path}:{line}: {name} is a number outside the settings"
    for path, name in sorted(kept.keys() - seen):
        yield f"{HOUSE}/{path}: no {name}; take it off the list of tests/layout/loose_constants.py"


def self_test():
    caught = ["constexpr double kFar = 1e5;", "inline constexpr int kN = 3;", "  const double least = 0.1, most = 3.0;",
              "static constexpr std::size_t kParts{3};",
              "const auto f = [&] {\n  constexpr int kN = 3;\n  return kN;\n};",
              "constexpr auto kHalf = 0.5;", "const int rounds = 3;",
              "constexpr double kTwo =\n    2.0;  // why", "constexpr Vec3 kUsual{0, 0, -9.81};",
              "constexpr std::array<double, 2> kEdges{0.1, 0.5};", "constexpr double kWide = 2.0 * 3.0;"]
    free = ["constexpr double kInf = std::numeric_limits<double>::infinity();", "// constexpr int kN = 3;",
            'constexpr const char* kName = "x = 3";', "const double share = settings.share;",
            "static constexpr int kLanes = Kind<T>::kLanes;", "const double half = 0.5 * width;",
            "const int n = static_cast<int>(x.size());", "for (int i = 0; i < 3; ++i) {"]
    for text in caught:
        assert list(complaints({f"{HOUSE}/fit/x.cpp": text}, {})), f"not caught: {text}"
    for text in free:
        assert not list(complaints({f"{HOUSE}/fit/x.cpp": text}, {})), f"wrongly caught: {text}"
    assert len(constants("const double least = 0.1, most = 3.0;")) == 2
    assert not list(complaints({f"{HOUSE}/settings.h": caught[0]}, {})), "settings are the place for them"
    assert not list(complaints({f"{HOUSE}/fit/x.cpp": caught[0]}, {("fit/x.cpp", "kFar"): "a reason"}))
    assert list(complaints({}, {("fit/x.cpp", "kFar"): "a reason"})), "a kept name that is gone"
    assert all(len(reason) > 4 for reason in KEPT.values())


def main():
    self_test()
    root = pathlib.Path(sys.argv[1])
    files = {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8")
             for p in sorted((root / HOUSE).rglob("*")) if p.suffix in (".h", ".cpp", ".inc")}
    found = list(complaints(files, KEPT))
    print("\n".join(found + [f"{len(files)} files read, {len(KEPT)} constants kept, {len(found)} complaints"]))
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())

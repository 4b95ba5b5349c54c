// Asks every case with every setting scaled, keeps each answer as it comes, and compares.
#include "tools/bench/diagnose/sensitivity.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "shared/files/atomic_file.h"
#include "shared/files/json.h"
#include "tools/bench/diagnose/case_folder.h"
#include "tools/bench/diagnose/scaled_setting.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/run/diagnose.h"

namespace sanso::bench {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ScaledAnswer, setting, factor, name, said, right,
                                   wrong_confirmed)
namespace {

namespace fs = std::filesystem;

/// One setting scaled; an empty name: all as they are.
struct Variant {
  std::string setting;
  double factor = 1.0;
  diagnose::Settings settings;
};

bool asked_for(const std::vector<std::string>& only, const std::string& name) {
  const std::string group = name.substr(0, name.find('.'));
  return only.empty() || std::any_of(only.begin(), only.end(),
                                     [&](const std::string& o) { return o == name || o == group; });
}

void require_known(const std::vector<std::string>& only) {
  const std::vector<std::string> names = setting_names();
  for (const std::string& o : only) {
    const bool known = std::any_of(names.begin(), names.end(),
                                   [&](const std::string& n) { return asked_for({o}, n); });
    if (!known) {
      throw std::invalid_argument("no setting or group '" + o +
                                  "'; they stand in docs/settings-diagnose.md");
    }
  }
}

/// Half of one attempt is one attempt: such a variant is none.
std::vector<Variant> variants(const std::vector<std::string>& only) {
  std::vector<Variant> out{{}};
  for (const std::string& name : setting_names()) {
    if (!asked_for(only, name)) continue;
    for (const double factor : {0.5, 2.0}) {
      const diagnose::Settings settings = scaled({}, fmt::format("{}={}", name, factor));
      if (value_of(settings, name) != value_of({}, name)) out.push_back({name, factor, settings});
    }
  }
  return out;
}

ScaledAnswer ask(const CaseFiles& c, const Variant& variant) {
  ScaledAnswer out{variant.setting, variant.factor, c.name, ""};
  diagnose::DiagnoseOptions task;
  task.settings = variant.settings;
  task.model = c.model;
  task.recordings = c.recordings;
  try {
    const diagnose::Diagnosis found = diagnose::diagnose(task, [](const std::string&) {});
    const CaseJudgement said = judge(c.answer, diagnose::verdict_json(found.verdict));
    out.said = fmt::format("{} {}", to_string(said.status), fmt::join(said.named, " + "));
    out.right = said.right;
    out.wrong_confirmed = said.wrong_confirmed;
  } catch (const std::exception& error) {
    out.said = fmt::format("no answer: {}", error.what());
  }
  return out;
}

/// Answers by what was asked, written after each, so that a stopped run goes on.
class Kept {
 public:
  Kept(fs::path file, bool resume, std::size_t wanted) : file_(std::move(file)), wanted_(wanted) {
    if (resume && fs::exists(file_))
      answers_ = files::read_json(file_).get<std::vector<ScaledAnswer>>();
    before_ = answers_.size();
  }
  bool has(const Variant& v, const std::string& name) const {
    return std::any_of(answers_.begin(), answers_.end(), [&](const ScaledAnswer& a) {
      return a.setting == v.setting && a.factor == v.factor && a.name == name;
    });
  }
  void add(ScaledAnswer answer) {
    const std::lock_guard<std::mutex> lock(mutex_);
    answers_.push_back(std::move(answer));
    files::write_atomically(file_, nlohmann::json(answers_).dump(1) + "\n");
    say(answers_.back());
  }
  const std::vector<ScaledAnswer>& answers() const { return answers_; }

 private:
  void say(const ScaledAnswer& a) const {
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    const auto here = static_cast<double>(answers_.size() - before_);
    const double left = seconds / here * static_cast<double>(wanted_ - answers_.size());
    fmt::print(stderr, "[{}/{}, {:.0f} min left] {} x {:g}, {}: {}\n", answers_.size(), wanted_,
               left / 60.0, a.setting.empty() ? "as it is" : a.setting, a.factor, a.name, a.said);
  }

  fs::path file_;
  std::size_t wanted_, before_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::vector<ScaledAnswer> answers_;
  std::mutex mutex_;
};

using ByCase = std::map<std::string, ScaledAnswer>;

std::string counted(const ByCase& answers) {
  int right = 0, wrong = 0;
  for (const auto& [name, a] : answers) right += a.right, wrong += a.wrong_confirmed;
  return fmt::format("{} of {} right, {} `CONFIRMED` wrongly", right, answers.size(), wrong);
}

/// What differs from the answers as they are; empty: nothing.
std::string differences(const ByCase& base, const ByCase& scaled) {
  std::string out;
  for (const auto& [name, a] : scaled) {
    const auto before = base.find(name);
    if (before == base.end() || before->second.said == a.said) continue;
    out += fmt::format("; {}: {}", name, a.said);
  }
  return out.empty() ? out : counted(scaled) + out;
}

}  // namespace

std::string sensitivity_table(const std::vector<ScaledAnswer>& answers) {
  std::map<std::pair<std::string, double>, ByCase> by_variant;
  std::vector<std::string> settings;
  for (const ScaledAnswer& a : answers) {
    by_variant[{a.setting, a.factor}][a.name] = a;
    const bool listed = std::find(settings.begin(), settings.end(), a.setting) != settings.end();
    if (!a.setting.empty() && !listed) settings.push_back(a.setting);
  }
  std::sort(settings.begin(), settings.end());  // the order of answers is that of their ends
  const ByCase& base = by_variant[{"", 1.0}];
  std::string out = fmt::format("As they are: {}.\n\n", counted(base)), rows;
  for (const auto& [name, a] : base) out += fmt::format("- {}: {}\n", name, a.said);
  std::vector<std::string> same;
  for (const std::string& s : settings) {
    const std::string half = differences(base, by_variant[{s, 0.5}]),
                      twice = differences(base, by_variant[{s, 2.0}]);
    if (half.empty() && twice.empty())
      same.push_back(fmt::format("`{}`", s));
    else
      rows += fmt::format("| `{}` | {} | {} |\n", s, half.empty() ? "the same" : half,
                          twice.empty() ? "the same" : twice);
  }
  out += fmt::format("\nThe same answers with half and double of {} of {}: {}.\n\n", same.size(),
                     settings.size(), fmt::join(same, ", "));
  return out + "| setting | halved | doubled |\n|---|---|---|\n" + rows;
}

int bench_sensitivity(const SensitivityOptions& options) {
  require_known(options.only);
  const std::vector<CaseFiles> cases = read_cases(options.folder);
  const std::vector<Variant> all = variants(options.only);
  fs::create_directories(options.out);
  Kept kept(fs::path(options.out) / "sensitivity.json", options.resume, all.size() * cases.size());
  std::vector<std::pair<const Variant*, const CaseFiles*>> open;
  for (const Variant& v : all) {
    for (const CaseFiles& c : cases)
      if (!kept.has(v, c.name)) open.emplace_back(&v, &c);
  }
  diagnose::parallel_for(open.size(),
                         [&](std::size_t i) { kept.add(ask(*open[i].second, *open[i].first)); });
  fmt::print("{}", sensitivity_table(kept.answers()));
  return 0;
}

}  // namespace sanso::bench

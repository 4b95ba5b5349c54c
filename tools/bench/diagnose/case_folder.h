// A folder of cases by any generator: nominal model, recordings, held-out recordings, answer.json
// in plain text; and the judgement of a verdict on one of them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/diagnose/case_family.h"
#include "tools/diagnose/verdict/finding.h"

namespace sanso::bench {

/// One way to write a true parameter; a generator may know several that describe the same world.
struct TrueParameter {
  std::vector<std::string> names;  // the first is the library's, the others are accepted
  std::vector<double> values;      // unit of the library's table; any of them counts
};

struct TrueEffect {
  std::string id;
  std::vector<std::string> also;          // names that describe the same physics
  std::vector<std::string> where_accept;  // joints and links; empty: any
  std::vector<TrueParameter> parameters;
};

/// What answer.json says.
struct CaseAnswer {
  CaseFamily family = CaseFamily::clean;
  std::string robot;   // with its variant, "arm/torque"
  double ratio = 0.0;  // reached, change of the positions over noise; 0: clean, decoy
  std::vector<TrueEffect> effects;
  std::vector<std::string> one_of;          // ambiguous: the set
  std::vector<std::string> decoy_channels;  // decoy: what a refusal may name
  double noise = 0.0;                       // RMS of the position noise, rad or m
  double oracle_explained = 0.0;            // share of the error at 0.5 s that the truth removes
};

struct CaseFiles {
  std::string name, folder, model;
  std::vector<std::string> recordings, heldout;
  CaseAnswer answer;
};

/// Every sub-folder of `folder` that holds an answer.json, by name. Throws files::InputError
/// naming the file and the key when one cannot be read, or when there is none.
std::vector<CaseFiles> read_cases(const std::string& folder);

/// Throws files::InputError; `file` is only named in its message.
CaseAnswer parse_answer(const std::string& text, const std::string& file);

/// What was said and how much of it is true. Fields that the family does not ask for stay false.
struct CaseJudgement {
  diagnose::VerdictStatus status = diagnose::VerdictStatus::absent;
  std::vector<std::string> named;  // effects of the findings, in order, "id@place"
  bool detected = false;           // a mismatch is said to be there
  bool named_first = false;        // the first finding is a true effect
  bool in_set = false;             // every true effect is a finding or in a finding's set
  bool place_right = false;        // every finding of a true effect stands where it is
  bool refused = false;            // decoy: refused, naming one of its channels
  bool unnamed = false;            // outside: said present, nothing CONFIRMED
  bool right = false;              // all that the family asks for
  int wrong_confirmed = 0;         // CONFIRMED findings that are not there
  double f1 = 0.0;                 // over effects
  double set_size = 0.0;           // mean over the findings
  std::map<std::string, double> relative_error;  // "effect.parameter"
  std::map<std::string, bool> covered;           // whether its 95 % interval holds the truth
};

/// `verdict`: text of verdict.json. Throws files::InputError when it is none.
CaseJudgement judge(const CaseAnswer& answer, const std::string& verdict);

}  // namespace sanso::bench

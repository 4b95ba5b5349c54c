// Opens a sealed case and compares a verdict with it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/conceal/conceal.h"

namespace sanso::conceal {

/// How a verdict did on one case. Only the fields that the family asks for mean something.
struct Score {
  std::string robot;
  Family family = Family::clean;
  double ratio_target = 0;                 // 0: clean, decoy
  std::vector<std::string> truth;          // effect ids
  std::vector<double> ratios;              // reached, by effect
  std::string status;                      // of the verdict
  std::vector<std::string> beside;         // what an effect brought along: no mistake to name
  std::vector<std::string> named;          // effect ids of the findings, in order
  int confirmed = 0, wrong_confirmed = 0;  // findings; of them neither true nor brought along
  bool detected = false;                   // said that there is a mismatch
  bool named_first = false;                // first finding is a true effect
  // every true effect is a finding or in a finding's set
  bool in_set = false;
  double set_size = 0;           // mean size of the sets
  bool where_exact = false;      // joints and links of every true effect
  double f1 = 0;                 // over effects; what was brought along does not count
  bool refused_by_name = false;  // decoy: the right defect
  // outside: said present, unnamed, and the right joint
  bool unnamed = false;
  bool right = false;  // what the family asks for
  // of each true parameter that was fitted, by "effect.parameter"
  std::map<std::string, double> relative_error;
  std::map<std::string, bool> covered;  // whether its interval holds the truth
  std::string hash;                     // of the seal
};

/// Throws plant::WorldError when DIR holds no case or the verdict cannot be read.
Score reveal(const std::string& directory, const std::string& verdict_file);

std::string to_json(const Score& score);

}  // namespace sanso::conceal

// libyaml's events, from which the mapping under the key `offset` is taken; the tuner's poses
// beside it are passed over.
#include "firmware/config/offsets_file.h"

#ifdef SANSO_HAVE_YAML
#include <yaml.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>
#include <utility>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::firmware {

#ifdef SANSO_HAVE_YAML

namespace {

// a horn has 16 teeth or so: more than that is another mistake
constexpr double kLargest_rad = 0.4;

/// ROBOTIS' names, index = servo id - 1.
constexpr std::array<const char*, 20> kNames{
    "r_sho_pitch", "l_sho_pitch", "r_sho_roll", "l_sho_roll", "r_el",
    "l_el",        "r_hip_yaw",   "l_hip_yaw",  "r_hip_roll", "l_hip_roll",
    "r_hip_pitch", "l_hip_pitch", "r_knee",     "l_knee",     "r_ank_pitch",
    "l_ank_pitch", "r_ank_roll",  "l_ank_roll", "head_pan",   "head_tilt"};

class OffsetsReader {
 public:
  OffsetsReader(std::string name, JointOffsets& offsets, std::string& error)
      : name_(std::move(name)), offsets_(offsets), error_(error) {}

  bool run(const std::string& text) {
    yaml_parser_t parser;
    if (yaml_parser_initialize(&parser) == 0) return fail(0, "cannot be parsed");
    yaml_parser_set_input_string(&parser, reinterpret_cast<const unsigned char*>(text.data()),
                                 text.size());
    bool more = true, good = true;
    while (more && good) {
      yaml_event_t event;
      if (yaml_parser_parse(&parser, &event) == 0) {
        good = fail(parser.problem_mark.line,
                    parser.problem != nullptr ? parser.problem : "is no YAML");
        break;
      }
      more = event.type != YAML_STREAM_END_EVENT;
      good = take(event);
      yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    if (good && !found_) return fail(0, "expected a mapping 'offset' of joint names to radians");
    return good;
  }

 private:
  bool fail(std::size_t line, const std::string& what) {
    error_ = name_ + ":" + std::to_string(line + 1) + ": " + what;
    return false;
  }

  bool take(const yaml_event_t& event) {
    switch (event.type) {
      case YAML_MAPPING_START_EVENT:
        if (++depth_ == 2 && key_ == "offset") inside_ = found_ = true;
        key_.clear();
        break;
      case YAML_SEQUENCE_START_EVENT:
        ++depth_;
        key_.clear();
        break;
      case YAML_MAPPING_END_EVENT:
      case YAML_SEQUENCE_END_EVENT:
        if (--depth_ == 1) inside_ = false;
        break;
      case YAML_SCALAR_EVENT:
        return scalar(std::string(reinterpret_cast<const char*>(event.data.scalar.value),
                                  event.data.scalar.length),
                      event.start_mark.line);
      default:
        break;
    }
    return true;
  }

  /// Scalars of a mapping come in pairs: key, value.
  bool scalar(const std::string& text, std::size_t line) {
    if (key_.empty()) {
      key_ = text;
      return true;
    }
    const std::string key = std::exchange(key_, {});
    if (!inside_ || depth_ != 2) return true;
    const auto joint = std::find(kNames.begin(), kNames.end(), key);
    if (joint == kNames.end())
      return fail(line, "offset." + key + ": expected a joint of the OP3, such as r_hip_yaw");
    if (!seen_.insert(key).second) return fail(line, "offset." + key + ": given twice");
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (end == text.c_str() || *end != 0 || !(std::abs(value) <= kLargest_rad))
      return fail(line, "offset." + key + " = " + text + ": expected radians from -0.4 to 0.4");
    offsets_[static_cast<std::size_t>(joint - kNames.begin())] = value;
    return true;
  }

  std::string name_;
  JointOffsets& offsets_;
  std::string& error_;
  std::string key_;
  std::set<std::string> seen_;
  int depth_ = 0;
  bool inside_ = false, found_ = false;
};

}  // namespace

bool parse_offsets(const std::string& text, const std::string& name, JointOffsets& offset_rad,
                   std::string& error) {
  JointOffsets read{};
  if (!OffsetsReader(name, read, error).run(text)) return false;
  offset_rad = read;
  return true;
}

#else

bool parse_offsets(const std::string&, const std::string& name, JointOffsets&, std::string& error) {
  error = name + ": this program was built without libyaml and cannot read offsets";
  return false;
}

#endif

bool read_offsets_file(const std::string& path, JointOffsets& offset_rad, std::string& error) {
  try {
    return parse_offsets(files::read_text(path), path, offset_rad, error);
  } catch (const files::InputError&) {
    error = path + ": cannot be read, expected the offsets file of the robot (offset.yaml)";
    return false;
  }
}

}  // namespace sanso::firmware

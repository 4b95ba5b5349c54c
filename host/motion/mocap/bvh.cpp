// A recursive reader over the words of the file; forward kinematics afterwards, frame by frame.
#include "host/motion/mocap/bvh.h"

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <map>
#include <string>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::motion {
namespace {

constexpr std::size_t kMaxFrames = 1'000'000;

/// Words of the text one by one, with the line each one stands in.
class Words {
 public:
  Words(const std::string& text, const std::string& file) : text_(text), file_(file) {}

  std::string next(const char* expected) {
    std::string word = peek();
    if (word.empty()) fail("end of file", expected);
    at_ += word.size();
    return word;
  }
  std::string peek() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) {
      if (text_[at_] == '\n') ++line_;
      ++at_;
    }
    std::size_t end = at_;
    while (end < text_.size() && !std::isspace(static_cast<unsigned char>(text_[end]))) ++end;
    return text_.substr(at_, end - at_);
  }
  void expect(const char* word) {
    const std::string found = next(word);
    if (found != word) fail("'" + found + "'", std::string("'") + word + "'");
  }
  double number(const char* what) {
    const std::string word = next(what);
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) {
      fail("'" + word + "'", std::string("a number (") + what + ")");
    }
    return value;
  }
  std::size_t count(const char* what, std::size_t limit) {
    const double value = number(what);
    if (value < 0 || value > static_cast<double>(limit) || value != std::floor(value)) {
      fail(std::to_string(value),
           std::string("a whole number up to ") + std::to_string(limit) + " (" + what + ")");
    }
    return static_cast<std::size_t>(value);
  }
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw ClipError(file_ + ":" + std::to_string(line_) + ": found " + found + ", expected " +
                    expected);
  }

 private:
  const std::string& text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 1;
};

BvhChannel read_channel(Words& words) {
  static const std::map<std::string, BvhChannel> kNames = {
      {"Xposition", BvhChannel::x_position}, {"Yposition", BvhChannel::y_position},
      {"Zposition", BvhChannel::z_position}, {"Xrotation", BvhChannel::x_rotation},
      {"Yrotation", BvhChannel::y_rotation}, {"Zrotation", BvhChannel::z_rotation}};
  const std::string word = words.next("a channel name");
  const auto found = kNames.find(word);
  if (found == kNames.end()) words.fail("'" + word + "'", "one of Xposition .. Zrotation");
  return found->second;
}

Eigen::Vector3d read_offset(Words& words) {
  words.expect("OFFSET");
  Eigen::Vector3d offset;
  for (int k = 0; k < 3; ++k) offset[k] = words.number("OFFSET");
  return offset;
}

/// Reads one joint and everything below it, the word ROOT or JOINT already taken.
void read_joint(Words& words, BvhClip& clip, int parent, int& channels) {
  const int self = static_cast<int>(clip.joints.size());
  clip.joints.emplace_back();
  clip.joints[self].name = words.next("a joint name");
  clip.joints[self].parent = parent;
  words.expect("{");
  clip.joints[self].offset = read_offset(words);
  words.expect("CHANNELS");
  const std::size_t n = words.count("CHANNELS", 6);
  clip.joints[self].first_channel = channels;
  channels += static_cast<int>(n);
  for (std::size_t k = 0; k < n; ++k) clip.joints[self].channels.push_back(read_channel(words));
  for (std::string word = words.next("JOINT, End or }"); word != "}";
       word = words.next("JOINT, End or }")) {
    if (word == "JOINT") {
      read_joint(words, clip, self, channels);
    } else if (word == "End") {
      words.expect("Site");
      words.expect("{");
      read_offset(words);
      words.expect("}");
    } else {
      words.fail("'" + word + "'", "JOINT, End Site or }");
    }
  }
}

void read_frames(Words& words, BvhClip& clip, int channels) {
  words.expect("MOTION");
  words.expect("Frames:");
  const std::size_t n = words.count("number of frames", kMaxFrames);
  words.expect("Frame");
  words.expect("Time:");
  clip.frame_time_s = words.number("frame time");
  if (clip.frame_time_s <= 0.0)
    words.fail(std::to_string(clip.frame_time_s), "a frame time above 0 s");
  clip.frames.reserve(n);
  for (std::size_t f = 0; f < n; ++f) {
    std::vector<double> row(static_cast<std::size_t>(channels));
    for (double& value : row) value = words.number("channel value");
    clip.frames.push_back(std::move(row));
  }
  if (!words.peek().empty()) {
    words.fail("'" + words.peek() + "'", "the end of the file after " + std::to_string(n) +
                                             " frames of " + std::to_string(channels) + " values");
  }
}

Eigen::Matrix3d elementary_rotation(BvhChannel channel, double degrees) {
  const int axis = static_cast<int>(channel) - static_cast<int>(BvhChannel::x_rotation);
  return Eigen::AngleAxisd(degrees * M_PI / 180.0, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
}

}  // namespace

int BvhClip::joint(const std::string& name) const {
  std::string known;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].name == name) return static_cast<int>(j);
    known += (j ? ", " : "") + joints[j].name;
  }
  throw ClipError(file + ": no joint named '" + name + "'; the file has " + known);
}

std::vector<Eigen::Vector3d> BvhClip::positions(std::size_t frame) const {
  const std::vector<double>& row = frames.at(frame);
  std::vector<Eigen::Vector3d> position(joints.size());
  std::vector<Eigen::Matrix3d> rotation(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const BvhJoint& joint = joints[j];
    Eigen::Vector3d offset = joint.offset;
    Eigen::Matrix3d local = Eigen::Matrix3d::Identity();
    bool replaced = false;
    for (std::size_t k = 0; k < joint.channels.size(); ++k) {
      const double value = row[static_cast<std::size_t>(joint.first_channel) + k];
      if (joint.channels[k] < BvhChannel::x_rotation) {
        // a position channel stands for the whole offset, not for an addition to it
        if (!replaced) offset.setZero();
        replaced = true;
        offset[static_cast<int>(joint.channels[k])] = value;
      } else {
        local = local * elementary_rotation(joint.channels[k], value);
      }
    }
    const bool root = joint.parent < 0;
    rotation[j] = root ? local : Eigen::Matrix3d(rotation[joint.parent] * local);
    position[j] =
        root ? offset : Eigen::Vector3d(position[joint.parent] + rotation[joint.parent] * offset);
  }
  return position;
}

BvhClip parse_bvh(const std::string& text, const std::string& name) {
  BvhClip clip;
  clip.file = name;
  Words words(text, clip.file);
  words.expect("HIERARCHY");
  words.expect("ROOT");
  int channels = 0;
  read_joint(words, clip, -1, channels);
  read_frames(words, clip, channels);
  if (clip.frames.empty()) throw ClipError(name + ": the clip has no frames");
  return clip;
}

BvhClip read_bvh(const std::string& path) {
  try {
    return parse_bvh(files::read_text(path), path);
  } catch (const files::InputError& error) {
    throw ClipError(error.what() + std::string("; give the path of a BVH file"));
  }
}

}  // namespace sanso::motion

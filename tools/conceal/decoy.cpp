// Each kind spoils one file in one way that happens with real loggers, and returns the name that
// the gate has to say.
#include "tools/conceal/decoy.h"

#include <cmath>

#include "tools/conceal/hidden_world.h"

namespace sanso::conceal {
namespace {

using recording::Recording;

std::vector<double> channel(const Recording& r, const std::string& name) {
  const auto values = r.find(name);
  return {values.begin(), values.end()};
}

/// A signed 16-bit register logged as unsigned.
void wrap16(Recording& r, const std::string& joint) {
  auto values = channel(r, "i:" + joint);
  for (double& x : values) x = x < 0 ? x + 65536 * kCurrentQuantum : x;
  r.set("i:" + joint, values);
}

void freeze(Recording& r, const std::string& joint, plant::Random& random) {
  auto values = channel(r, "q:" + joint);
  const std::size_t from = values.size() / 4 + random.bits() % (values.size() / 4);
  for (std::size_t row = from; row < from + values.size() / 5; ++row) values[row] = values[from];
  r.set("q:" + joint, values);
}

void degrees(Recording& r, const std::string& joint) {
  auto values = channel(r, "q:" + joint);
  for (double& x : values) x *= 180 / 3.14159265358979323846;
  r.set("q:" + joint, values);
}

void flip(Recording& r, const std::string& joint) {
  for (const char* kind : {"q:", "dq:"}) {
    auto values = channel(r, kind + joint);
    for (double& x : values) x = -x;
    r.set(kind + joint, values);
  }
}

void swap_joints(Recording& r, const std::string& a, const std::string& b) {
  for (const char* kind : {"q:", "dq:"}) {
    const auto first = channel(r, kind + a), second = channel(r, kind + b);
    r.set(kind + a, second);
    r.set(kind + b, first);
  }
}

}  // namespace

Decoy spoil(std::vector<Recording>& recordings, plant::Random& random) {
  Recording& r = recordings[random.bits() % recordings.size()];
  const auto joints = r.joints();
  const std::string& joint = joints[random.bits() % joints.size()];
  switch (random.bits() % (joints.size() > 1 ? 8 : 7)) {
    case 0:
      wrap16(r, joint);
      return {"16-bit wrap", r.file};
    case 1:
      freeze(r, joint, random);
      return {"stuck channel", r.file};
    case 2:
      degrees(r, joint);
      return {"wrong unit", r.file};
    case 3:
      flip(r, joint);
      return {"wrong sign", r.file};
    case 4:
      r.set("u:" + joint, channel(r, "q:" + joint));
      return {"command is a copy of the position", r.file};
    case 5: {
      const std::string name = r.file;
      const Recording& other = &r == &recordings[0] ? recordings[1] : recordings[0];
      const Recording copy = other;
      r.t = copy.t;
      r.channels = copy.channels;
      return {"copy of another file", name};
    }
    case 6: {
      for (std::size_t row = r.t.size() / 2; row < r.t.size(); ++row) r.t[row] -= 1.0;
      return {"time runs backwards", r.file};
    }
    default: {
      const std::string& other = joints[0] == joint ? joints[1] : joints[0];
      swap_joints(r, joint, other);
      return {"swapped joints", r.file};
    }
  }
}

}  // namespace sanso::conceal

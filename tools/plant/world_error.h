// What a world file or the emulated robot's set-up can be refused for; the message says where and
// what was expected.
#pragma once

#include <stdexcept>

namespace sanso::plant {

struct WorldError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace sanso::plant

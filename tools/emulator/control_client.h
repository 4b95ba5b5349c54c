// The other end of the emulator's control socket: for the host's command line, for tests and for
// people.
#pragma once

#include <string>

namespace sanso::emulator {

/// Sends one JSON command to the emulator that serves `directory` and returns its answer.
/// Throws plant::WorldError when no emulator is there or none answers within two seconds.
std::string tell_emulator(const std::string& directory, const std::string& json);

}  // namespace sanso::emulator

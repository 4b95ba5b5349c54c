// The speed that the client of a pty has set, as the master sees it.
#pragma once

namespace sanso::emulator {

/// Bits a second; 0 when `master` is no pty.
int line_speed(int master);

}  // namespace sanso::emulator

// termios2 knows any speed; its header and termios.h exclude each other, hence a file of its own.
#include "tools/emulator/line_speed.h"

#include <asm/termbits.h>
#include <sys/ioctl.h>

namespace sanso::emulator {

int line_speed(int master) {
  termios2 settings{};
  if (master < 0 || ioctl(master, TCGETS2, &settings) != 0) return 0;
  return static_cast<int>(settings.c_ospeed);
}

}  // namespace sanso::emulator

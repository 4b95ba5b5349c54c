// Prints docs/settings.md.
#include <cstdio>

#include "firmware/config/settings_page.h"

int main() {
  std::fputs(sanso::firmware::settings_page().c_str(), stdout);
  return 0;
}

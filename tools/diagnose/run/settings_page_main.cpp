// Prints docs/settings-diagnose.md.
#include <cstdio>

#include "tools/diagnose/run/settings_page.h"

int main() {
  std::fputs(sanso::diagnose::settings_page().c_str(), stdout);
  return 0;
}

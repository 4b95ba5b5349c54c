// Prints docs/settings-learn.md.
#include <cstdio>

#include "host/app/learn_settings.h"

int main() {
  std::fputs(sanso::app::learn_settings_page().c_str(), stdout);
  return 0;
}

// Prints docs/faults.md.
#include <cstdio>

#include "firmware/app/faults_page.h"

int main() {
  std::fputs(sanso::firmware::faults_page().c_str(), stdout);
  return 0;
}

// The page as it was built from tools/page/web: gzip streams, empty where npm could not be had.
#pragma once

#include <span>

namespace sanso::page {

struct Bundle {
  std::span<const unsigned char> page;    // the live page, whole
  std::span<const unsigned char> script;  // of a report: window.sansoPage.replay
  std::span<const unsigned char> style;   // of a report
  std::span<const unsigned char> film;    // window.sansoPage.film, for a page that nobody sees
  bool empty() const { return page.empty(); }
};

const Bundle& bundle();

/// What to tell a person when the bundle is empty.
inline constexpr char kNoBundle[] =
    "this sanso was built without its page (npm or its registry could not be had): install nodejs "
    "and npm, remove tools/page/bundle.cpp in the build folder and build again";

}  // namespace sanso::page

// Words and units of the diagnosis report.
#include "tools/diagnose/run/report_words.h"

#include <algorithm>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {

std::string wrapped(const std::string& text, std::size_t width) {
  std::string out;
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::size_t word = end - at;
    if (line > 0 && line + 1 + word > width) out += '\n', line = 0;
    if (line > 0) out += ' ', ++line;
    out.append(text, at, word), line += word;
    at = end + 1;
  }
  return out + "\n";
}

std::string joined(const std::vector<std::string>& parts, const char* empty) {
  std::string text;
  for (const std::string& p : parts) text += (text.empty() ? "" : ", ") + p;
  return text.empty() ? empty : text;
}

std::string in_words(const std::string& id) {
  const Effect* effect = find_effect(id);
  return effect == nullptr ? id : std::string(effect->name) + " (" + id + ")";
}

std::string position_unit(const Diagnosis& d) {
  const auto sliding =
      std::count_if(d.slides.begin(), d.slides.end(), [](char s) { return s != 0; });
  if (sliding == 0) return "rad";
  return sliding == static_cast<std::ptrdiff_t>(d.slides.size()) ? "m"
                                                                 : "rad (m at sliding joints)";
}

bool slides_of(const Diagnosis& d, const std::string& joint) {
  const auto at = std::find(d.joints.begin(), d.joints.end(), joint) - d.joints.begin();
  return static_cast<std::size_t>(at) < d.slides.size() && d.slides[at] != 0;
}

}  // namespace sanso::diagnose

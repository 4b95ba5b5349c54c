// The page inside a report, as markup that needs nothing else, and a page around it for what nobody
// sees.
#pragma once

#include <string>
#include <string_view>

namespace sanso::page {

/// The page was built into this program; else there is nothing to embed.
bool available();

/// `call`: a function of window.sansoPage ("replay", "mechanism") that draws `zipped`, a gzip
/// stream of PackedRuns. One a report. Needs available().
std::string embedded(const std::string& call, std::string_view zipped);

/// A whole page that calls sansoPage.film with `zipped` and the JSON text `options`.
std::string film_page(std::string_view zipped, const std::string& options);

}  // namespace sanso::page

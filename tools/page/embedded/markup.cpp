// Script, style and data lie in the report as base64 of gzip streams; a few lines unpack them.
#include "tools/page/embedded/markup.h"

#include <fmt/format.h>

#include "tools/page/embedded/bundle.h"
#include "tools/page/embedded/packing.h"

namespace sanso::page {
namespace {

std::string hidden(const char* id, std::string_view bytes) {
  return fmt::format("<script type='text/plain' id='{}'>{}</script>\n", id, base64(bytes));
}

std::string_view text_of(std::span<const unsigned char> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

constexpr char kUnpacker[] = R"(<script>
const get=async id=>{const text=atob(document.getElementById(id).textContent);
const zipped=Uint8Array.from(text,c=>c.charCodeAt(0));
const plain=new Blob([zipped]).stream().pipeThrough(new DecompressionStream('gzip'));
return new Uint8Array(await new Response(plain).arrayBuffer())};
const add=async(tag,id)=>{const e=document.createElement(tag);
e.textContent=new TextDecoder().decode(await get(id));document.head.append(e)};
</script>
)";

constexpr char kLoader[] = R"(<script>(async()=>{
await add('style','replay-style');await add('script','replay-script');
const at=document.getElementById('replay');sansoPage[at.dataset.call](at,await get('replay-data'));
})().catch(e=>{document.getElementById('replay').textContent='no replay here: '+e.message})</script>
)";

}  // namespace

bool available() { return !bundle().empty(); }

std::string embedded(const std::string& call, std::string_view zipped) {
  const Bundle& all = bundle();
  return fmt::format("<div id='replay' data-call='{}'></div>\n", call) +
         hidden("replay-style", text_of(all.style)) + hidden("replay-script", text_of(all.script)) +
         hidden("replay-data", zipped) + kUnpacker + kLoader;
}

std::string film_page(std::string_view zipped, const std::string& options) {
  return "<!DOCTYPE html><html><head><meta charset='utf-8'><link rel='icon' href='data:,'>"
         "<style>body{margin:0}</style></head><body>\n" +
         hidden("film-script", text_of(bundle().film)) + hidden("film-data", zipped) + kUnpacker +
         fmt::format(
             "<script>(async()=>{{await add('script','film-script');"
             "await sansoPage.film(await get('film-data'),{})}})()</script></body></html>",
             options);
}

}  // namespace sanso::page

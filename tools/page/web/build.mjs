// Bundles the page and writes it as C++: gzip streams (page, script, style, film) that
// tools/page/embedded/bundle.h hands out.
// Usage: node build.mjs OUT.cpp
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

async function bundled(entry) {
  const made = await build({
    entryPoints: [entry], bundle: true, minify: true, format: "iife", target: "es2022",
    legalComments: "inline", write: false,
  });
  return made.outputFiles[0].text.replaceAll("</script", "<\\/script");
}
const script = await bundled("src/main.js"), film = await bundled("src/film.js");
const style = readFileSync("src/style.css", "utf8").replace(/\n/g, "");
const page = readFileSync("index.html", "utf8")
  .replace("/*STYLE*/", () => style).replace("/*SCRIPT*/", () => script);

const bytes = (name, text) => {
  const zipped = gzipSync(text, { level: 9 });
  const rows = [];
  for (let i = 0; i < zipped.length; i += 64) rows.push([...zipped.subarray(i, i + 64)].join(","));
  return `const unsigned char k${name}[] = {\n${rows.join(",\n")}};\n`;
};
writeFileSync(process.argv[2],
  `// Made by tools/page/web/build.mjs.\n#include "tools/page/embedded/bundle.h"\n\nnamespace sanso::page {\nnamespace {\n` +
  bytes("Page", page) + bytes("Script", script) + bytes("Style", style) + bytes("Film", film) +
  `}  // namespace\n\nconst Bundle& bundle() {\n` +
  `  static const Bundle kBundle{kPage, kScript, kStyle, kFilm};\n  return kBundle;\n}\n\n}  // namespace sanso::page\n`);

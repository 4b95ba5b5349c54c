// Binary, with a fingerprint of data and settings: a file of another search is refused instead
// of continued.
#include "host/learn/model/identification_store.h"

#include "shared/files/framed.h"

namespace sanso::learn {
namespace {

constexpr char kIdentificationMagic[] = "SANSOCEM";
constexpr std::uint32_t kIdentificationVersion = 1;

void get_sized(files::FramedReader& in, Eigen::VectorXd& v, std::uint32_t size) {
  if (in.left() / sizeof(double) < size) in.fail();
  v.resize(size);
  in.get(v);
}

}  // namespace

void save_search(const std::filesystem::path& path, const CrossEntropyState& state,
                 std::uint64_t fingerprint) {
  files::FramedWriter out;
  out.put(fingerprint);
  out.put(static_cast<std::int32_t>(state.generation));
  out.put(state.best_loss);
  out.put(static_cast<std::uint32_t>(state.mean.size()));
  out.put(state.mean);
  out.put(state.deviation);
  out.put(state.best);
  files::save_framed(path, kIdentificationMagic, kIdentificationVersion, out.bytes());
}

CrossEntropyState load_search(const std::filesystem::path& path, std::uint64_t fingerprint) {
  files::FramedReader in = files::load_framed(path, kIdentificationMagic, kIdentificationVersion);
  if (in.read<std::uint64_t>() != fingerprint)
    throw std::runtime_error(
        path.string() +
        ": a search over other recordings, or with another seed or population; "
        "resume it with what it began with, or name another folder");
  CrossEntropyState state;
  state.generation = in.read<std::int32_t>();
  in.get(state.best_loss);
  const auto size = in.read<std::uint32_t>();
  for (Eigen::VectorXd* v : {&state.mean, &state.deviation, &state.best}) get_sized(in, *v, size);
  return state;
}

}  // namespace sanso::learn

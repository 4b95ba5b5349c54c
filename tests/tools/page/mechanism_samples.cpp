// Pages with the robot of a diagnosis, for a browser to look at: an arm with every kind of joint
// and a mesh, one joint of which the nominal model moves wrongly, and a body that floats.
// Usage: mechanism_samples FOLDER
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "tests/support/small_world.h"
#include "tools/diagnose/run/report_sections.h"

namespace {

using namespace sanso;
using namespace sanso::diagnose;

/// A pyramid of binary STL.
std::string pyramid() {
  const float corners[5][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 2}};
  const int sides[6][3] = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  std::string out(80, ' ');
  const std::uint32_t count = 6;
  out.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const auto& side : sides) {
    const float normal[3] = {0, 0, 0};
    out.append(reinterpret_cast<const char*>(normal), sizeof normal);
    for (const int corner : side)
      out.append(reinterpret_cast<const char*>(corners[corner]), sizeof corners[corner]);
    out.append(2, '\0');
  }
  return out;
}

ModelFolder arm_with_a_mesh(const std::filesystem::path& folder) {
  ModelFolder model = test::arm("actuator = \"torque\"\n");
  const std::string mark = "<link name=\"rod\">";
  model.urdf.insert(model.urdf.find(mark) + mark.size(),
                    "<visual><geometry><mesh filename=\"package://arm/tip.stl\" "
                    "scale=\"0.03 0.03 0.03\"/></geometry></visual>");
  model.folder = folder.string();
  std::ofstream(folder / "tip.stl", std::ios::binary) << pyramid();
  return model;
}

ShownMotion waves(const std::string& name, bool floating, std::size_t joints) {
  constexpr int kRows = 150;
  ShownMotion m{name, 0.02, {}};
  for (int k = 0; k < kRows; ++k) {
    const double t = 0.02 * k;
    m.numbers.push_back(10.0 + t);
    for (int figure = 0; figure < 3; ++figure) {
      if (floating) {
        const double falls = figure == 1 ? 0.05 : 0.0;
        for (const double v : {0.3 * t, 0.0, 0.3 - falls + 0.1 * std::sin(3 * t), std::cos(0.5 * t),
                               0.0, 0.0, std::sin(0.5 * t)})
          m.numbers.push_back(v);
      }
      for (std::size_t j = 0; j < joints; ++j)
        m.numbers.push_back((j == 2 ? 0.1 : 0.8) * std::sin((2.0 + double(j)) * t) +
                            (figure == 1 && j == 1 && !floating ? 0.1 : 0.0));
    }
  }
  return m;
}

void write(const std::filesystem::path& file, const Verdict& v, const ModelFolder& model) {
  report::HtmlPage page("The robot of a diagnosis");
  const auto joints = model.tree.joints.size();
  ShownMotions shown;
  for (const char* recording : {"first.csv", "second.csv"})
    shown.motions.push_back(waves(recording, model.floating, joints));
  tell_robot(page, v, model, shown);
  std::ofstream(file) << page.finish();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  Verdict v;
  Finding finding;
  finding.effect = "backlash";
  finding.where = {"b"};
  v.findings.push_back(finding);
  finding.effect = "payload";
  finding.where = {"rod"};
  v.findings.push_back(finding);
  write(folder / "arm.html", v, arm_with_a_mesh(folder));
  ModelFolder body = test::two_links("actuator = \"torque\"\n");
  body.floating = true;
  write(folder / "floating.html", {}, body);
  return 0;
}

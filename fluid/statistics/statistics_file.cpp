#include "fluid/statistics/statistics_file.hpp"

#include <fmt/format.h>

#include <numbers>
#include <utility>

#include "fluid/files/atomic_file.hpp"
#include "fluid/files/hdf5_file.hpp"

namespace bedload {
namespace {

constexpr std::uint64_t metadata_room = 1 << 20;

using Profile = std::vector<double> FlowStatistics::*;

/// The columns of the group "profiles": name, values, unit, meaning.
struct Column {
  const char* name;
  Profile values;
  const char* unit;
  const char* meaning;
};
constexpr Column columns[] = {
    {"y", &FlowStatistics::y, "L", "cell centres"},
    {"y_face", &FlowStatistics::y_face, "L", "cell faces"},
    {"fluid", &FlowStatistics::fluid, "-", "share of the centres that lie in the fluid"},
    {"fluid_face", &FlowStatistics::fluid_face, "-", "share of the faces that lie in the fluid"},
    {"u", &FlowStatistics::u, "L/T", "intrinsic mean of u at centres"},
    {"v", &FlowStatistics::v, "L/T", "intrinsic mean of v at faces"},
    {"w", &FlowStatistics::w, "L/T", "intrinsic mean of w at centres"},
    {"p", &FlowStatistics::p, "L^2/T^2", "intrinsic mean of p/rho at centres"},
    {"uu", &FlowStatistics::uu, "L^2/T^2", "<u'u'> at centres"},
    {"vv", &FlowStatistics::vv, "L^2/T^2", "<v'v'> at faces"},
    {"ww", &FlowStatistics::ww, "L^2/T^2", "<w'w'> at centres"},
    {"uv", &FlowStatistics::uv, "L^2/T^2", "<u'v'> at faces"},
    {"uw", &FlowStatistics::uw, "L^2/T^2", "<u'w'> at centres"},
    {"vw", &FlowStatistics::vw, "L^2/T^2", "<v'w'> at faces"},
    {"pp", &FlowStatistics::pp, "L^4/T^4", "<p'p'>/rho^2 at centres"},
    {"grains", &FlowStatistics::grains, "-", "share of the volume that spheres fill"},
    {"mobile", &FlowStatistics::mobile, "-", "share of the volume that mobile spheres fill"},
    {"grain_u", &FlowStatistics::grain_u, "L/T", "mean of u of the mobile spheres' material"},
    {"grain_v", &FlowStatistics::grain_v, "L/T", "mean of v of the mobile spheres' material"},
    {"grain_w", &FlowStatistics::grain_w, "L/T", "mean of w of the mobile spheres' material"},
    {"grain_spin", &FlowStatistics::grain_spin, "1/T", "mean spin of the mobile spheres about z"},
    {"viscous", &FlowStatistics::viscous, "M/(L T^2)", "mu d<u>/dy at faces, all points"},
    {"turbulent", &FlowStatistics::turbulent, "M/(L T^2)", "-rho <u v> at faces, all points"},
    {"acceleration", &FlowStatistics::acceleration, "M/(L^2 T^2)", "rho d<u>/dt, all points"},
    {"spheres", &FlowStatistics::spheres, "M/(L^2 T^2)",
     "force of the spheres (side walls, fringe) on the fluid per volume, closes the balance"},
};

void write_list(Hdf5File& file, const std::string& name, const std::vector<double>& values) {
  const std::uint64_t n = values.size();
  file.write(name, {{n}, {0}, {n}}, values.data());
}

void write_spectra(Hdf5File& file, const FlowStatistics& statistics) {
  const std::vector<FlowStatistics::Spectra>& spectra = statistics.spectra;
  file.make_group("spectra");
  file.set_attribute<double>("spectra", "wavenumber_step", statistics.wavenumber_step);
  for (std::size_t n = 0; n < spectra.size(); ++n) {
    const std::string group = fmt::format("spectra/height_{}", n);
    file.make_group(group);
    file.set_attribute(group, "height", spectra[n].height);
    for (std::size_t c = 0; c < 3; ++c) {
      write_list(file, fmt::format("{}/{}_along_x", group, "uvw"[c]), spectra[n].x[c]);
      write_list(file, fmt::format("{}/{}_along_z", group, "uvw"[c]), spectra[n].z[c]);
    }
  }
}

}  // namespace

void write_statistics(const std::string& folder, const FlowStatistics& s) {
  const std::string path = folder + "/statistics.h5";
  require_space(path, metadata_room);
  Hdf5File file(temporary_name(path), Hdf5File::Access::create, MPI_COMM_SELF);
  file.set_attribute("/", "samples", s.samples);
  for (const auto& [name, value] :
       {std::pair{"begin", s.begin}, {"end", s.end}, {"driving", s.driving}})
    file.set_attribute("/", name, value);
  for (const auto& [name, value] :
       {std::pair{"u_tau", s.u_tau}, {"re_tau", s.re_tau}, {"stress_defect", s.stress_defect}})
    if (value) file.set_attribute("/", name, *value);
  file.set_attribute<double>("/", "wall_stress", s.wall_stress);
  file.make_group("profiles");
  for (const Column& column : columns) {
    const std::string name = fmt::format("profiles/{}", column.name);
    write_list(file, name, s.*column.values);
    file.set_text(name, "unit", column.unit);
    file.set_text(name, "meaning", column.meaning);
  }
  if (!s.spectra.empty()) write_spectra(file, s);
  file.close();
  commit_file(path);
}

std::string statistics_summary(const FlowStatistics& s) {
  std::string text =
      fmt::format("statistics: {} samples, t = {:.6g} to {:.6g}; ", s.samples, s.begin, s.end);
  if (s.u_tau) text += fmt::format("u_tau = {:.5g}, Re_tau = {:.4g}, ", *s.u_tau, *s.re_tau);
  text += fmt::format("wall stress {:.4g} and {:.4g}", s.wall_stress[0], s.wall_stress[1]);
  if (s.stress_defect)
    text += fmt::format(", stress off its straight line by {:.2g} %", 100.0 * *s.stress_defect);
  return text + "\n";
}

}  // namespace bedload

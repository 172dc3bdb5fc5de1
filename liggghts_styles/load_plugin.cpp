#include "liggghts_styles/load_plugin.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "liggghts_styles/plugin.hpp"

namespace bedload {

void load_plugin(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg) {
  if (narg != 2 || std::string_view(arg[0]) != "load")
    stop_run(lmp,
             fmt::format("plugin: found '{}', allowed is 'load FILE'", narg > 0 ? arg[0] : ""));
  const std::string file = arg[1];
  // A name without a folder would be looked for among the system's libraries.
  const std::string path = std::filesystem::absolute(file).string();
  if (!std::filesystem::is_regular_file(path))
    stop_run(lmp, fmt::format("plugin: there is no file '{}'", path));
  const bool again = dlopen(path.c_str(), RTLD_NOW | RTLD_NOLOAD) != nullptr;
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) stop_run(lmp, fmt::format("plugin: {}", dlerror()));
  const auto entry = reinterpret_cast<const Plugin* (*)()>(dlsym(library, plugin_entry));
  if (entry == nullptr)
    stop_run(lmp,
             fmt::format("plugin: '{}' is no plug-in of bedload: it lacks BEDLOAD_PLUGIN", path));
  if (entry()->facts != PluginFacts{})
    stop_run(lmp,
             fmt::format("plugin: '{}' was compiled for another bedload or LIGGGHTS; compile it "
                         "anew with the headers of this one",
                         path));
  if (!again) entry()->add_models();
}

}  // namespace bedload

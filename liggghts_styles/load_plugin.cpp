#include "liggghts_styles/load_plugin.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>

#include "liggghts_styles/plugin.hpp"

namespace bedload {

void load_plugin(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg) {
  const std::string file = Arguments(lmp, plugin_help, std::span(arg, narg)).word("load");
  if (file.empty()) stop_run(lmp, "plugin needs the keyword 'load <file>'");
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

#pragma once

#include <cstddef>
#include <string>

#include "liggghts_styles/normal_model_actm.hpp"
#include "liggghts_styles/register_combinations.hpp"
#include "liggghts_styles/tangential_model_haff_werner.hpp"

/// A contact model of one's own in one file, compiled into a plug-in that a script loads by the
/// line `plugin load FILE`. User page doc/plugin.md; a complete one is in tests/second_project.
namespace bedload {

/// What a plug-in and the program that loads it have to agree in: both were compiled with these
/// sizes, else they see each other's objects wrongly.
struct PluginFacts {
  int format = 2;
  std::size_t lubrication = sizeof(FixLubrication);
  std::size_t marker_film = sizeof(FixMarkerFilm);
  std::size_t collision_table = sizeof(FixCollisionTable);
  std::size_t touching = sizeof(LIGGGHTS::ContactModels::SurfacesIntersectData);
  std::size_t liggghts = sizeof(LAMMPS_NS::LAMMPS);

  bool operator==(const PluginFacts&) const = default;
};

/// What a plug-in brings: its models, as names for the script.
struct Plugin {
  PluginFacts facts;
  void (*add_models)();
};

/// Names of the functions by which the program finds what is in a plug-in.
inline constexpr const char* plugin_entry = "bedload_plugin";

/// Makes `pair_style gran model NAME` and `fix wall/gran model NAME` known, with tangential off,
/// haff_werner and history. The specialisation NormalModel<Id> is the model; Id is free from 32 to
/// 63. Other combinations: register_combination (register_combinations.hpp).
template <int Id>
void add_normal_model(const std::string& name) {
  using namespace LIGGGHTS::ContactModels;
  static_assert(Id >= 32 && Id < 64, "ids below 32 belong to LIGGGHTS and bedload");
  Factory::instance().addNormalModel(name, Id);
  register_combination<Id, TANGENTIAL_OFF, ROLLING_OFF>();
  register_combination<Id, BEDLOAD_HAFF_WERNER, ROLLING_OFF>();
  register_combination<Id, TANGENTIAL_HISTORY, ROLLING_OFF>();
}

/// Makes `... model hertz|actm tangential NAME` known; the specialisation TangentialModel<Id> is
/// the model.
template <int Id>
void add_tangential_model(const std::string& name) {
  using namespace LIGGGHTS::ContactModels;
  static_assert(Id >= 32 && Id < 64, "ids below 32 belong to LIGGGHTS and bedload");
  Factory::instance().addTangentialModel(name, Id);
  register_combination<HERTZ, Id, ROLLING_OFF>();
  register_combination<BEDLOAD_ACTM, Id, ROLLING_OFF>();
}

}  // namespace bedload

/// Stands before the braces with the calls of add_normal_model and add_tangential_model.
#define BEDLOAD_PLUGIN                                                                        \
  static void bedload_add_models();                                                           \
  extern "C" __attribute__((visibility("default"))) const bedload::Plugin* bedload_plugin() { \
    static const bedload::Plugin plugin{{}, bedload_add_models};                              \
    return &plugin;                                                                           \
  }                                                                                           \
  static void bedload_add_models()

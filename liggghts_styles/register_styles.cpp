#include "liggghts_styles/register_styles.hpp"

#include <iostream>

#include "liggghts_styles/data_file.hpp"
#include "liggghts_styles/load_plugin.hpp"
#include "liggghts_styles/normal_model_actm.hpp"
#include "liggghts_styles/normal_model_rpm.hpp"
#include "liggghts_styles/private_access.hpp"
#include "liggghts_styles/register_combinations.hpp"
#include "liggghts_styles/tangential_model_haff_werner.hpp"

namespace bedload {

namespace {

// Once per process: LIGGGHTS' tables of contact models are global.
bool register_contact_models() {
  using namespace LIGGGHTS::ContactModels;
  Factory& models = Factory::instance();
  models.addNormalModel("actm", BEDLOAD_ACTM);
  models.addNormalModel("rpm", BEDLOAD_RPM);
  models.addTangentialModel("haff_werner", BEDLOAD_HAFF_WERNER);
  // Some combinations of shipped models are replaced by observed ones, which LIGGGHTS reports on
  // cerr as a collision of names.
  std::streambuf* usual = std::cerr.rdbuf(nullptr);
  register_actm();
  register_rpm();
  register_shipped();
  std::cerr.rdbuf(usual);
  std::cerr.clear();
  return true;
}

}  // namespace

void register_styles(LAMMPS_NS::LAMMPS* lmp) {
  [[maybe_unused]] static const bool once = register_contact_models();
  add_fix_style<FixLubrication>(lmp, "lubrication");
  add_fix_style<FixCollisionTable>(lmp, "collision/table");
  add_fix_style<FixMarkerFilm>(lmp, FixMarkerFilm::style_name);
  add_command(lmp, "plugin", load_plugin);
  add_command(lmp, "read_data", read_checked_data);
}

std::vector<StyleHelp> styles() {
  using namespace LIGGGHTS::ContactModels;
  return {NormalModel<BEDLOAD_ACTM>::help,
          NormalModel<BEDLOAD_RPM>::help,
          TangentialModel<BEDLOAD_HAFF_WERNER>::help,
          FixLubrication::help,
          FixCollisionTable::help,
          plugin_help};
}

void check_styles(LAMMPS_NS::LAMMPS* lmp) {
  if (!has_fix_style(lmp, "lubrication")) {
    stop_run(lmp,
             "bedload's styles are not registered: the program has to define "
             "LAMMPS_NS::LAMMPS::post_create with default visibility");
  }
}

}  // namespace bedload

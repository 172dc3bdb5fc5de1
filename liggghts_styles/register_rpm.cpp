#include "liggghts_styles/normal_model_rpm.hpp"
#include "liggghts_styles/register_combinations.hpp"
#include "liggghts_styles/tangential_model_haff_werner.hpp"

namespace bedload {

void register_rpm() {
  using namespace LIGGGHTS::ContactModels;
  register_combination<BEDLOAD_RPM, BEDLOAD_HAFF_WERNER, ROLLING_OFF>();
  register_combination<BEDLOAD_RPM, TANGENTIAL_OFF, ROLLING_OFF>();
}

}  // namespace bedload

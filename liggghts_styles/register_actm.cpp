#include "liggghts_styles/normal_model_actm.hpp"
#include "liggghts_styles/register_combinations.hpp"
#include "liggghts_styles/tangential_model_haff_werner.hpp"

namespace bedload {

void register_actm() {
  using namespace LIGGGHTS::ContactModels;
  register_with_rolling<BEDLOAD_ACTM, BEDLOAD_HAFF_WERNER>();
  register_with_rolling<BEDLOAD_ACTM, TANGENTIAL_HISTORY>();
  register_with_rolling<BEDLOAD_ACTM, TANGENTIAL_OFF>();
}

}  // namespace bedload

#include "liggghts_styles/register_combinations.hpp"
#include "liggghts_styles/tangential_model_haff_werner.hpp"

namespace bedload {

// LIGGGHTS' own normal models: with our tangential model, and once more with its own ones, so that
// fix lubrication and fix collision/table serve them too.
void register_shipped() {
  using namespace LIGGGHTS::ContactModels;
  register_with_rolling<HERTZ, BEDLOAD_HAFF_WERNER>();
  register_with_rolling<HOOKE, BEDLOAD_HAFF_WERNER>();
  register_combination<HERTZ, TANGENTIAL_HISTORY, ROLLING_OFF>();
  register_combination<HERTZ, TANGENTIAL_OFF, ROLLING_OFF>();
  register_combination<HOOKE, TANGENTIAL_HISTORY, ROLLING_OFF>();
  register_combination<HOOKE, TANGENTIAL_OFF, ROLLING_OFF>();
}

}  // namespace bedload

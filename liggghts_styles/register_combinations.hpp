#pragma once

#include <span>
#include <type_traits>

#include "liggghts_styles/liggghts.hpp"
// clang-format off
#include "fix_insert_stream.h"
#include "pair_gran_base.h"
#include "fix_wall_gran_base.h"
// clang-format on
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/observed_contact_model.hpp"

/// Registering combinations of contact models with LIGGGHTS, for pairs and walls. Each combination
/// is a class of its own, so they are spread over several sources to keep compile times bearable.
namespace bedload {

/// Checks the numbers behind a contact model's own keywords (LIGGGHTS reads text as 0). A model
/// declares them as its member `keywords`; LIGGGHTS' own models have none.
template <class Model>
void check_keywords(LAMMPS_NS::LAMMPS* lmp, std::span<char*> words) {
  if constexpr (requires { Model::help; })
    check_numbers(lmp, Model::help.name, Model::keywords, words);
  else if constexpr (requires { Model::keywords; })
    check_numbers(lmp, "contact model", Model::keywords, words);
  if constexpr (requires { Model::choices; })
    check_choices(lmp, Model::help.name, Model::choices, words);
}

/// LIGGGHTS' machinery around a contact model (Granular for pairs or for walls), with checked
/// numbers.
template <class Machinery, class Parent, class NormalModel, class TangentialModel>
class Checked : public Machinery {
 public:
  Checked(LAMMPS_NS::LAMMPS* lmp, Parent* parent, std::int64_t hash)
      : Machinery(lmp, parent, hash), owner_(lmp) {}

  void settings(int count, char** arguments, LIGGGHTS::IContactHistorySetup* setup) override {
    const std::span<char*> words(arguments, count > 0 ? count : 0);
    check_keywords<NormalModel>(owner_, words);
    check_keywords<TangentialModel>(owner_, words);
    Machinery::settings(count, arguments, setup);
  }

 private:
  LAMMPS_NS::LAMMPS* owner_;
};

/// Registers the combination for `pair_style gran` and `fix wall/gran`.
template <int Normal, int Tangential, int Rolling>
void register_combination() {
  using namespace LIGGGHTS;
  using Style = ContactModels::GranStyle<Normal, Tangential, ContactModels::COHESION_OFF, Rolling,
                                         ContactModels::SURFACE_DEFAULT>;
  using Model = ObservedContactModel<Style>;
  using NormalPart = ContactModels::NormalModel<Normal>;
  using TangentialPart = ContactModels::TangentialModel<Tangential>;
  using Pairs =
      Checked<PairStyles::Granular<Model>, LAMMPS_NS::PairGran, NormalPart, TangentialPart>;
  using Wall = Checked<Walls::Granular<Model>, LAMMPS_NS::FixWallGran, NormalPart, TangentialPart>;
  PairStyles::Factory::instance().addStyle(
      "gran", Style::HASHCODE,
      [](LAMMPS_NS::LAMMPS* lmp, LAMMPS_NS::PairGran* parent, std::int64_t hash)
          -> PairStyles::IGranularPairStyle* { return new Pairs(lmp, parent, hash); });
  Walls::Factory::instance().addStyle(
      "gran", Style::HASHCODE,
      [](LAMMPS_NS::LAMMPS* lmp, LAMMPS_NS::FixWallGran* parent,
         std::int64_t hash) -> Walls::IGranularWall* { return new Wall(lmp, parent, hash); });
}

/// The combination without rolling friction and with LIGGGHTS' two simple rolling models.
template <int Normal, int Tangential>
void register_with_rolling() {
  using namespace LIGGGHTS::ContactModels;
  register_combination<Normal, Tangential, ROLLING_OFF>();
  register_combination<Normal, Tangential, ROLLING_CDT>();
  register_combination<Normal, Tangential, ROLLING_EPSD2>();
}

void register_actm();
void register_rpm();
void register_shipped();

}  // namespace bedload

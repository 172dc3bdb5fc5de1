#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fix_mesh_surface.h"
#include "fix_wall_gran.h"
#include "liggghts_styles/fix_collision_table.hpp"
#include "liggghts_styles/fix_lubrication.hpp"
#include "liggghts_styles/fix_marker_film.hpp"
#include "liggghts_styles/impulse_on_walls.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/unknown_setting.hpp"

namespace bedload {

/// A LIGGGHTS contact model (any combination) that also tells fix lubrication which surfaces are
/// close, fix collision/table which contacts act, and the coupling's FixMarkerFilm which spheres
/// touch or nearly do. These fixes thus serve all models, shipped ones included, and pairs,
/// primitive and mesh walls alike, without a search of their own; without the fixes it costs a test
/// of a pointer each per contact.
template <class Style>
class ObservedContactModel : public LIGGGHTS::ContactModels::ContactModel<Style> {
  using Base = LIGGGHTS::ContactModels::ContactModel<Style>;
  using Touching = LIGGGHTS::ContactModels::SurfacesIntersectData;
  using Close = LIGGGHTS::ContactModels::SurfacesCloseData;
  using Forces = LIGGGHTS::ContactModels::ForceData;

 public:
  ObservedContactModel(LAMMPS_NS::LAMMPS* lmp, LIGGGHTS::IContactHistorySetup* setup, bool is_wall,
                       std::int64_t hash)
      : Base(lmp, setup, is_wall, hash), lmp_(lmp) {
    if (is_wall) wall_ = dynamic_cast<LAMMPS_NS::FixWallGran*>(setup);
  }

  void registerSettings(Settings& settings) {
    Base::registerSettings(settings);
    catch_unknown_settings(settings);
  }

  void connectToProperties(PropertyRegistry& registry) {
    Base::connectToProperties(registry);
    LAMMPS_NS::Modify& modify = *lmp_->modify;
    lubrication_ = find_lubrication(lmp_);
    table_ = static_cast<FixCollisionTable*>(modify.find_fix_style_strict("collision/table", 0));
    marker_film_ = wall_ == nullptr ? find_marker_film(lmp_) : nullptr;
    if (lubrication_ != nullptr) lubrication_->prepare(wall_);
    if (marker_film_ != nullptr) marker_film_->prepare();
    if (table_ != nullptr) table_->attach(wall_);
    on_walls_ = wall_ != nullptr ? find_impulse_on_walls(lmp_) : nullptr;
    mobility_ = Mobility(lmp_);
  }

  void surfacesIntersect(Touching& s, Forces& i_forces, Forces& j_forces) {
    Base::surfacesIntersect(s, i_forces, j_forces);
    if (on_walls_ != nullptr && s.computeflag && s.shearupdate) push_wall(s, s.en, i_forces);
    if (marker_film_ != nullptr && s.computeflag &&
        marker_film_->reaches(s.i, s.j, s.rsq, s.radsum))
      marker_film_->add(s.i, s.j, -s.deltan, s.en);
    if (table_ == nullptr || !s.computeflag || !s.shearupdate) return;
    const double slip = std::sqrt(s.vtr1 * s.vtr1 + s.vtr2 * s.vtr2 + s.vtr3 * s.vtr3);
    record(s, s.en, -s.deltan, s.vn, slip, i_forces);
  }

  void surfacesClose(Close& s, Forces& i_forces, Forces& j_forces) {
    Base::surfacesClose(s, i_forces, j_forces);
    const bool acts = table_ != nullptr && s.has_force_update && s.shearupdate;
    const bool film = lubrication_ != nullptr && lubrication_->reaches(s.rsq, s.radsum);
    const bool markers =
        marker_film_ != nullptr && marker_film_->reaches(s.i, s.j, s.rsq, s.radsum);
    const bool pushes = on_walls_ != nullptr && s.has_force_update && s.shearupdate;
    if (!s.computeflag || (!film && !markers && !acts && !pushes)) return;
    const double r = std::sqrt(s.rsq);
    const double gap = r - s.radsum;
    const double n[3] = {s.delta[0] / r, s.delta[1] / r, s.delta[2] / r};
    if (pushes) push_wall(s, n, i_forces);
    if (markers) marker_film_->add(s.i, s.j, gap, n);
    if (film) {
      const double effective = s.is_wall ? s.radi : s.radi * s.radj / s.radsum;
      const double smaller = s.is_wall ? s.radi : std::min(s.radi, s.radj);
      lubrication_->add({s.i, s.is_wall ? -1 : s.j, gap, effective, smaller, n,
                         s.is_wall ? s.v_j : nullptr, false, false});
    }
    if (acts) record_close(s, r, gap, i_forces);
  }

 private:
  /// A wall gets what the sphere does not get from it.
  void push_wall(const Close& s, const double* n, const Forces& forces) {
    if (mobility_.inverse_mass(*lmp_->atom, s.i, -1) == 0) return;
    const double* force = forces.delta_F;
    on_walls_->take(n, force[0], lmp_->update->dt);
  }

  void record_close(const Close& s, double r, double gap, const Forces& i_forces) {
    double n[3], v[3], vn = 0, squared = 0;
    for (int d = 0; d < 3; ++d) {
      n[d] = s.delta[d] / r;
      v[d] = s.v_i[d] - s.v_j[d];
      vn += v[d] * n[d];
      squared += v[d] * v[d];
    }
    record(s, n, gap, vn, std::sqrt(std::max(0.0, squared - vn * vn)), i_forces);
  }

  void record(const Close& s, const double* n, double gap, double normal_speed, double slip,
              const Forces& forces) {
    const LAMMPS_NS::Atom& atom = *lmp_->atom;
    const double* f = forces.delta_F;
    if (f[0] == 0 && f[1] == 0 && f[2] == 0) return;
    const double inverse_mass = mobility_.inverse_mass(atom, s.i, s.is_wall ? -1 : s.j);
    if (inverse_mass == 0) return;
    table_->touch({s.i,
                   s.is_wall ? -1 : s.j,
                   s.is_wall ? wall_number(s) : 0,
                   {n[0], n[1], n[2]},
                   gap,
                   s.radi,
                   normal_speed,
                   slip,
                   {f[0], f[1], f[2]},
                   inverse_mass});
  }

  /// The same on all ranks, in each run and behind a restart, whatever other fixes come and go: FNV
  /// hash of the name of the wall's (or mesh's) fix, from 1.
  int wall_number(const Close& s) const {
    const char* id = s.fix_mesh != nullptr ? s.fix_mesh->id : wall_ != nullptr ? wall_->id : "";
    std::uint32_t hash = 2166136261u;
    for (; *id != '\0'; ++id) hash = (hash ^ static_cast<unsigned char>(*id)) * 16777619u;
    return 1 + static_cast<int>(hash >> 2);
  }

  LAMMPS_NS::LAMMPS* lmp_;
  LAMMPS_NS::FixWallGran* wall_ = nullptr;
  FixLubrication* lubrication_ = nullptr;
  FixMarkerFilm* marker_film_ = nullptr;
  FixCollisionTable* table_ = nullptr;
  ImpulseOnWalls* on_walls_ = nullptr;
  Mobility mobility_;
};

}  // namespace bedload

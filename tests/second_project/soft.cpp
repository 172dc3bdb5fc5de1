// A collision model in one file: a linear spring and a linear damper,
//
//   F = k δ - c g_n,   e = exp(-π ζ / sqrt(1 - ζ²)),   ζ = c / (2 sqrt(k m)),
//
// with the overlap δ, the normal relative velocity g_n (positive where the surfaces part) and the
// effective mass m. In a script:
//
//   plugin load soft.so
//   pair_style gran model soft tangential haff_werner stiffness 100 damping 0.1
#include "liggghts_styles/plugin.hpp"

namespace LIGGGHTS::ContactModels {

inline constexpr int SOFT = 32;  // any number from 32 to 63 that no other plug-in takes

template <>
class NormalModel<SOFT> : public NormalModelBase {
 public:
  NormalModel(LAMMPS* lammps, IContactHistorySetup* history, ContactModelBase* model)
      : NormalModelBase(lammps, history, model) {}

  // Name, allowed values (above 0), default, unit and meaning; wrong values end the run with a
  // sentence.
  static constexpr bedload::NumberKeyword keywords[] = {
      {"stiffness", 0, false, bedload::no_limit, 100, "", "N/m", "Spring constant k."},
      {"damping", 0, true, bedload::no_limit, 0, "", "kg/s", "Damping constant c."}};

  void registerSettings(Settings& settings) override {
    bedload::read_setting(settings, keywords[0], stiffness_);
    bedload::read_setting(settings, keywords[1], damping_);
  }
  void postSettings(IContactHistorySetup*, ContactModelBase*) override {}
  void connectToProperties(PropertyRegistry&) override {}
  double stressStrainExponent() override { return 1.0; }
  void beginPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}
  void endPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}

  // Surfaces that overlap. en is the unit vector towards sphere i.
  void surfacesIntersect(SurfacesIntersectData& s, ForceData& i_forces,
                         ForceData& j_forces) override {
    if (s.contact_flags) *s.contact_flags |= CONTACT_NORMAL_MODEL;
    const double force = stiffness_ * s.deltan - damping_ * s.vn;
    s.Fn = force;  // what tangential models ask for
    s.kn = stiffness_;
    s.kt = 2.0 / 7.0 * stiffness_;
    s.gamman = s.gammat = damping_;
    for (int d = 0; d < 3; ++d) {
      i_forces.delta_F[d] += force * s.en[d];
      if (!s.is_wall) j_forces.delta_F[d] -= force * s.en[d];
    }
  }
  void surfacesClose(SurfacesCloseData&, ForceData&, ForceData&) override {}

 private:
  double stiffness_ = 0, damping_ = 0;
};

}  // namespace LIGGGHTS::ContactModels

BEDLOAD_PLUGIN { bedload::add_normal_model<LIGGGHTS::ContactModels::SOFT>("soft"); }

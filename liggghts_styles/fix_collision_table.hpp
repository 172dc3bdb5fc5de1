#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <unordered_map>
#include <vector>

#include "fix.h"
#include "liggghts_styles/contact_observers.hpp"
#include "liggghts_styles/keywords.hpp"

namespace bedload {

/// One step of one contact, as the contact models see it.
struct ContactStep {
  int i, j;                      ///< local indices; j = -1 for a wall
  int wall;                      ///< number of the wall, 0 for a pair
  std::array<double, 3> normal;  ///< unit vector towards i
  double gap;                    ///< [m], negative in overlap
  double radius;                 ///< of i [m]
  double normal_speed;           ///< rate at which the gap opens, before this step's force [m/s]
  double tangential_speed;       ///< slip speed at the contact point [m/s]
  std::array<double, 3> force;   ///< on i [N]
  double inverse_mass;           ///< of the pair [1/kg]
};

/// Writes one row per finished contact of spheres of the group, with each other, with other spheres
/// and with walls. User page doc/fix_collision_table.md.
///
/// A contact is kept by the rank that owns the sphere of the lower tag, and moves with it.
class FixCollisionTable : public LAMMPS_NS::Fix {
 public:
  static constexpr WordKeyword words[] = {{"file", "none, required", "Name of the table."}};
  static constexpr NumberKeyword keywords[] = {{"every", 1, true, 1e9, 1000, "", "DEM steps",
                                                "Steps between two writings of new rows.", true}};
  static constexpr StyleHelp help{
      "fix collision/table",
      "One row of comma-separated values per finished contact, between spheres or with a wall.",
      "fix ID group collision/table file NAME [every N]", keywords, words};

  FixCollisionTable(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixCollisionTable() override;

  int setmask() override;
  void init() override;
  /// At the start of a run LIGGGHTS hands spheres on as well.
  void setup_pre_neighbor() override { pre_neighbor(); }
  void pre_neighbor() override;
  void end_of_step() override;
  void post_run() override;
  void setup(int) override;
  double compute_scalar() override;
  /// "started": not null once a run has begun the table.
  void* extract(const char* name, int& dimension) override;

  void write_restart(std::FILE* file) override;
  void restart(char* buffer) override;
  int pack_restart(int i, double* buffer) override;
  void unpack_restart(int local, int nth) override;
  int size_restart(int local) override;
  int maxsize_restart() override;

  /// Called by the contact models for every contact that exerts a force in this step.
  void touch(const ContactStep& step);

  /// Called by the contact models before a run: the table is fed.
  /// @param wall fix of the wall; none: the pairs
  void attach(const LAMMPS_NS::Fix* wall) { contact_observers_.add(wall); }

 private:
  /// A contact that is under way. Plain numbers only: it travels by MPI and in restart files.
  struct Record {
    double tag, other;  // other: tag of the partner, or -(number of the wall)
    double start_time;
    double position[3];
    double impact_speed, impact_slip;
    double normal_impulse, tangential_impulse[3];
    double last_step, last_time, last_gap, last_speed;
    double largest_overlap;
  };
  static constexpr int record_size = sizeof(Record) / sizeof(double);
  /// One row of the table, in the order of its columns.
  using Row = std::array<double, 13>;

  Record* find(double tag, double other);
  bool keep(const Record& record);
  double time() const;
  void set_clock();
  static Row row_of(const Record& record, double end);
  void finish(const Record& record);
  void write();
  void write_open();
  std::int64_t keep_rows(std::int64_t most) const;
  template <class Add>
  void add_to_file(const std::string& name, const char* mode, Add&& add);
  std::vector<Row> gathered(const std::vector<Row>& mine) const;

  std::string file_;
  std::int64_t every_ = static_cast<std::int64_t>(keywords[0].preset);
  bool started_ = false;
  ContactObservers contact_observers_;
  std::unordered_map<std::int64_t, std::vector<Record>> open_;  // by the lower tag
  std::vector<Row> finished_;
  std::int64_t count_ = 0;  // finished collisions so far
  std::int64_t rows_ = 0;   // of them in the file; known to the first rank
  // LIGGGHTS' clock begins anew after a restart or a reset_timestep; ours goes on. Beside a fluid
  // it is the fluid's, which begins at 0 whatever LIGGGHTS did before.
  double clock_offset_ = 0, last_time_ = 0, restart_time_ = 0;
  bool restarted_ = false, has_run_ = false, beside_fluid_ = false;
};

}  // namespace bedload

#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "fluid/grid/flow_view.hpp"

namespace bedload {

/// Snapshots of the flow, one HDF5 file for all of them with an XDMF file beside it.
///
/// Each quantity of the field list that is in the output, in float32 with shape (nz, ny, nx); what
/// lives on faces (u, v, w) is brought to the cell centres by the mean of the two. The file is
/// closed between snapshots, so that it can be opened while the run goes on, and the XDMF is
/// renewed after each.
class FieldWriter {
 public:
  /// Writes folder/fields.h5 and folder/fields.xdmf. `resume_after` >= 0 keeps the snapshots up to
  /// that step of a run that is continued; otherwise old files are replaced. Collective.
  FieldWriter(const std::string& folder, const Grid& grid, const Decomposition& decomposition,
              std::int64_t resume_after = -1);

  /// Adds the snapshot /step_%08d; one of the same step is replaced. Collective; throws UserError
  /// on all ranks.
  template <class Real>
  void write(const FlowView<Real>& flow);

 private:
  struct Snapshot {
    std::int64_t step;
    double time;
  };
  void create_file();
  void resume_file(std::int64_t step);
  void write_xdmf() const;

  std::string folder_, path_;
  Grid grid_;
  MPI_Comm comm_;
  std::vector<Snapshot> snapshots_;
};

}  // namespace bedload

#include "fluid/poisson/plane_transform.hpp"

#include "fluid/poisson/distributed_transform.hpp"
#include "fluid/poisson/local_transform.hpp"

namespace bedload {

template <class Real>
std::unique_ptr<PlaneTransform<Real>> make_plane_transform(const Grid& grid, int component,
                                                           const Decomposition& decomposition) {
  if (decomposition.divides_rows())
    return std::make_unique<DistributedTransform<Real>>(grid, component, decomposition);
  return std::make_unique<LocalTransform<Real>>(grid, component, decomposition);
}

template std::unique_ptr<PlaneTransform<float>> make_plane_transform(const Grid&, int,
                                                                     const Decomposition&);
template std::unique_ptr<PlaneTransform<double>> make_plane_transform(const Grid&, int,
                                                                      const Decomposition&);

}  // namespace bedload

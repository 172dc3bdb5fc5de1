#include "fluid/plane_transform.hpp"

#include "fluid/divided_transform.hpp"
#include "fluid/whole_transform.hpp"

namespace bedload {

template <class Real>
std::unique_ptr<PlaneTransform<Real>> make_plane_transform(const Grid& grid, int component,
                                                           const Decomposition& blocks) {
  if (blocks.divides_rows())
    return std::make_unique<DividedTransform<Real>>(grid, component, blocks);
  return std::make_unique<WholeTransform<Real>>(grid, component, blocks);
}

template std::unique_ptr<PlaneTransform<float>> make_plane_transform(const Grid&, int,
                                                                     const Decomposition&);
template std::unique_ptr<PlaneTransform<double>> make_plane_transform(const Grid&, int,
                                                                      const Decomposition&);

}  // namespace bedload

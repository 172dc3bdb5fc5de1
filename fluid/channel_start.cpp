#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "fluid/channel.hpp"
#include "fluid/diagnostics.hpp"
#include "fluid/errors.hpp"

// How a channel comes to the field that its first step starts from: given, restored, made free of
// divergence.

namespace bedload {

/// One projection over a unit time, from own planes to valid ghosts.
template <class Real>
void Channel<Real>::project_start_field() {
  close_own_planes();
  if (slabs_.at_upper_wall())
    for (int k = 0; k < slabs_.rows(); ++k) close_wall_face(slabs_.planes() - 1, k);
  for (int n = 0; n < slabs_.planes(); ++n)
    eliminate_plane(plane_of(forth_, n, slabs_.planes()), 0, 1.0);
  poisson_.couple();
  substitute_and_correct(
      {.step = 1.0, .shift = 0.0, .measure = false, .moved = 0, .pressure = PressureUse::none});
  fill_ghosts();
}

template <class Real>
void Channel<Real>::measure_start() {
  streamwise_sum_ = streamwise_sum(velocity_, grid_, slabs_);
  fastest_ = largest_local_speed(velocity_, grid_, slabs_);
  MPI_Allreduce(MPI_IN_PLACE, &fastest_, 1, MPI_DOUBLE, MPI_MAX, comm());
  choose_time_step();
  check_field();
  clock_ = {};
}

template <class Real>
void Channel<Real>::set_velocity(const std::function<double(int, const Vec3&)>& value) {
  for (int j = 0; j < slabs_.planes(); ++j)
    for (int k = 0; k < slabs_.rows(); ++k)
      for (int c = 0; c < 3; ++c) {
        Real* row = velocity_.row(j, k, c);
        for (int i = 0; i < grid_.cells[0]; ++i) {
          const int plane = slabs_.first() + j, line = slabs_.first_row() + k;
          const Vec3 place(c == 0 ? grid_.face(i) : grid_.centre(i),
                           c == 1 ? grid_.y_face(plane) : grid_.y_centre(plane),
                           c == 2 ? grid_.face(line) : grid_.centre(line));
          row[i] = static_cast<Real>(value(c, place));
        }
      }
  project_start_field();
  measure_start();
}

template <class Real>
void Channel<Real>::set_driving(double found) {
  switch (settings_.flow.driving) {
    case Driving::none:
      driving_ = 0.0;
      return;
    case Driving::pressure_gradient:
      driving_ = settings_.flow.pressure_gradient / settings_.fluid.density;
      return;
    case Driving::bulk_velocity:
      driving_ = found;
      return;
  }
}

template <class Real>
void Channel<Real>::restored(double time, std::int64_t step, double driving_force,
                             bool project_it) {
  time_ = time;
  step_ = step;
  set_driving(driving_force / settings_.fluid.density);
  if (project_it) {
    project_start_field();
  } else {
    close_own_planes();
  }
  renew_ghosts();
  measure_start();
}

template <class Real>
void Channel<Real>::renew_ghosts() {
  fill_ghosts();
  for (int j = 0; j < slabs_.planes(); ++j) walls_.close_scalar(pressure_, j);
  slabs_.exchange(pressure_);
}

template <class Real>
std::vector<double> Channel<Real>::running_numbers() const {
  return {driving_, streamwise_sum_, fastest_, dt_made_};
}

template <class Real>
void Channel<Real>::set_running_numbers(std::span<const double> numbers) {
  if (numbers.size() != running_numbers().size())
    throw UserError("The state's running numbers are not those of this program.");
  set_driving(numbers[0]);
  streamwise_sum_ = numbers[1];
  fastest_ = numbers[2];
  dt_made_ = numbers[3];
  choose_time_step();
}

template class Channel<float>;
template class Channel<double>;

}  // namespace bedload

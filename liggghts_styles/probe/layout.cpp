// Compares the sizes of the objects that the LIGGGHTS library makes with the sizes in its headers.
// Prints one sentence and returns 1 if they differ. Run by CMake.
#include <cstdio>
#include <cstdlib>
#include <new>

#include "contact_models.h"
// The order matters to LIGGGHTS.
#include "fix_insert_stream.h"
#include "pair_gran_base.h"
// clang-format off
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "force.h"
#include "input.h"
#include "neighbor.h"
#include "update.h"
// clang-format on

namespace {
/// Sizes that were asked for while recording.
class Sizes {
 public:
  void record(std::size_t size) {
    if (recording && count_ < most) sizes_[count_++] = size;
  }
  bool seen(std::size_t size) const {
    for (int n = 0; n < count_; ++n) {
      if (sizes_[n] == size) return true;
    }
    return false;
  }
  static inline bool recording = false;

 private:
  static constexpr int most = 100000;
  std::size_t sizes_[most];
  int count_ = 0;
};
Sizes objects;   // by operator new
Sizes contacts;  // records of contacts, the only objects that LIGGGHTS asks posix_memalign for
}  // namespace

void* operator new(std::size_t size) {
  objects.record(size);
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

extern "C" __attribute__((visibility("default"))) int posix_memalign(void** p,
                                                                     std::size_t alignment,
                                                                     std::size_t size) {
  contacts.record(size);
  *p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  return *p ? 0 : 12;
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  char program[] = "probe", log[] = "-log", screen[] = "-screen", none[] = "none";
  char* arguments[] = {program, log, none, screen, none};
  Sizes::recording = true;
  auto* lammps = new LAMMPS_NS::LAMMPS(5, arguments, MPI_COMM_WORLD);
  lammps->input->one("pair_style gran model hertz");
  Sizes::recording = false;

  // Does not link where the library counts in other integers.
  void (LAMMPS_NS::Domain::*volatile by_image)(double*, LAMMPS_NS::tagint&) =
      &LAMMPS_NS::Domain::remap;
  static_cast<void>(by_image);

  const struct {
    const char* name;
    std::size_t size;
    const Sizes* among = &objects;
  } expected[] = {
      {"LAMMPS", sizeof(LAMMPS_NS::LAMMPS)},
      {"Atom", sizeof(LAMMPS_NS::Atom)},
      {"Comm", sizeof(LAMMPS_NS::Comm)},
      {"Domain", sizeof(LAMMPS_NS::Domain)},
      {"Force", sizeof(LAMMPS_NS::Force)},
      {"Neighbor", sizeof(LAMMPS_NS::Neighbor)},
      {"Update", sizeof(LAMMPS_NS::Update)},
      {"SurfacesIntersectData", sizeof(LIGGGHTS::ContactModels::SurfacesIntersectData), &contacts},
      {"ForceData", sizeof(LIGGGHTS::ContactModels::ForceData), &contacts}};
  for (const auto& e : expected) {
    if (!e.among->seen(e.size)) {
      std::printf("class %s has %zu bytes in the headers, which the library never allocates",
                  e.name, e.size);
      std::fflush(stdout);
      std::_Exit(1);
    }
  }
  std::fflush(stdout);
  std::_Exit(0);
}

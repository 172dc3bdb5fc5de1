// Preloaded into the programs of a job, this counts what they take: memory that C++ and the fields
// ask for, messages to other ranks, sums over ranks. Each process leaves a line of JSON in the
// folder BEDLOAD_COUNTS at its end, also one that never heard of MPI: so it is known what was
// started.

#include <errno.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "tests/performance/message_counter.hpp"

namespace {

std::int64_t bytes = 0, at_last_message = 0;  // programs of one thread

void* taken(void* memory, std::size_t size) {
  if (memory == nullptr) throw std::bad_alloc();
  // As the C library hands it out: a text in which a number has a digit more takes no more.
  constexpr std::size_t unit = 16;
  bytes += static_cast<std::int64_t>((size + unit - 1) / unit * unit);
  return memory;
}

void* aligned(std::size_t size, std::size_t alignment) {
  void* memory = nullptr;
  return posix_memalign(&memory, alignment, size) == 0 ? memory : nullptr;
}

__attribute__((destructor)) void tell() {
  const char* const folder = std::getenv("BEDLOAD_COUNTS");
  if (folder == nullptr) return;
  char name[4096];
  std::snprintf(name, sizeof name, "%s/%d.json", folder, static_cast<int>(::getpid()));
  std::FILE* const file = std::fopen(name, "w");
  if (file == nullptr) return;
  const bedload::Traffic traffic = bedload::traffic();
  struct rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  std::fprintf(file,
               "{\"program\": \"%s\", \"bytes\": %ld, \"bytes_at_last_message\": "
               "%ld, \"messages\": %ld, "
               "\"bytes_sent\": %ld, \"sums\": %ld, \"gathered\": %ld, \"peak_bytes\": %ld}\n",
               program_invocation_short_name, static_cast<long>(bytes),
               static_cast<long>(at_last_message), static_cast<long>(traffic.messages),
               static_cast<long>(traffic.bytes), static_cast<long>(traffic.sums),
               static_cast<long>(traffic.gathered), usage.ru_maxrss * 1024L);
  std::fclose(file);
}

}  // namespace

void bedload::after_message() { at_last_message = bytes; }

void* operator new(std::size_t size) { return taken(std::malloc(size), size); }
void* operator new[](std::size_t size) { return taken(std::malloc(size), size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return taken(aligned(size, static_cast<std::size_t>(alignment)), size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

/// By which fields get their memory.
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return taken(aligned(size, alignment), size);
}

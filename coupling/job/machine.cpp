#include "coupling/job/machine.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <sstream>

namespace bedload {

std::string host_name() {
  std::array<char, 72> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

std::string machine_identity() {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  std::array<char, 64> processes{};  // "pid:[4026531836]"
  if (::readlink("/proc/self/ns/pid", processes.data(), processes.size() - 1) < 0) processes = {};
  return fmt::format("{} {} {}", host_name(), boot, processes.data());
}

unsigned long long process_start(int process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string text;
  if (!std::getline(file, text)) return 0;
  // Behind the name in parentheses, which may hold anything, begins field 3.
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string skipped;
  for (int field = 3; field < 22; ++field) fields >> skipped;
  unsigned long long start = 0;
  fields >> start;
  return start;
}

}  // namespace bedload

#pragma once

#include <string>

namespace bedload {

/// Host name, identity of the present boot and of the process table: two processes can signal each
/// other exactly when these words are the same for both. Containers may share a host name, and
/// often the boot, but have process tables of their own, in which the same number is another
/// process.
std::string machine_identity();

/// This machine's host name.
std::string host_name();

/// When a process began, in clock ticks since the boot (proc(5), /proc/PID/stat, field 22): with
/// its number, what tells it from a later one. 0: there is no such process here.
unsigned long long process_start(int process);

}  // namespace bedload

// Prints what tells this process's machine and process table from others.

#include <iostream>

#include "coupling/job/machine.hpp"

int main() { std::cout << bedload::machine_identity() << std::endl; }

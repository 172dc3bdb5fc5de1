#pragma once

#include <string>
#include <vector>

namespace bedload {

/// The folder of the shipped collision models (`models`) and parts of scripts (`beds`): beside the
/// program where it was installed, in its source tree where it was built. A path with blanks, which
/// no script could name, is given from the present folder on.
std::string inputs_folder();

/// The program's arguments with `-var inputs FOLDER` behind them, so that every script, in
/// whatever folder, may say `include ${inputs}/models/${model}.liggghts`. A variable that is set
/// before, on the command line, stays as it is.
std::vector<char*> with_inputs(int argc, char** argv, std::string& folder);

}  // namespace bedload

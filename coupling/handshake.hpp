#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupling/message.hpp"

namespace bedload {

/// Compares what the two programs know of the scene. Returns one sentence that names both values
/// and the lines to change where they disagree, nothing where they agree.
///
/// Lengths, gravity and material values agree when they differ by less than 1e-8 of their size: a
/// LIGGGHTS script computes with 15 digits, a person types fewer. Also refused: spheres of fewer
/// than four cells across (markers and their supports would fill the whole sphere), and unit
/// systems in which force is not mass times acceleration.
std::optional<std::string> disagreement(const FluidFacts& fluid, const DemFacts& dem);

/// What the scheme does not do well in such a scene, a sentence each; it runs nevertheless.
std::vector<std::string> cautions(const FluidFacts& fluid, const DemFacts& dem);

}  // namespace bedload

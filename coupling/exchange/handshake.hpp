#pragma once

#include <optional>
#include <string>

#include "coupling/exchange/message.hpp"

namespace bedload {

/// Compares what the two programs know of the scene. Returns one sentence that names both values
/// and the lines to change where they disagree, nothing where they agree. Whether the scene itself
/// is sound is the matter of fluid/validation.
///
/// Lengths, gravity and material values agree when they differ by less than 1e-8 of their size: a
/// LIGGGHTS script computes with 15 digits, a person types fewer. Also refused: unit systems in
/// which force is not mass times acceleration, and a group without atoms.
std::optional<std::string> disagreement(const FluidSceneInfo& fluid, const DemSceneInfo& dem);

/// The part of it that concerns the box.
std::optional<std::string> box_disagreement(const FluidSceneInfo& fluid, const DemSceneInfo& dem);

}  // namespace bedload

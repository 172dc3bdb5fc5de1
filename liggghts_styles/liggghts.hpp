#pragma once

// The headers of LIGGGHTS that our contact models are written against, in the order that they need.
// clang-format off
#include "contact_models.h"
#include "atom.h"
#include "comm.h"
#include "force.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"
// clang-format on

#pragma once

#include <algorithm>
#include <cstdio>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/private_member.hpp"
#include "settings.h"

namespace bedload {
namespace detail {

struct SettingsByName {
  friend constexpr auto member(SettingsByName);
};
template struct PrivateMember<SettingsByName, &Settings::settings>;

}  // namespace detail

/// LIGGGHTS asks the settings of a contact model in the order of their names which of them takes
/// the next word. This one stands last and meets what none has taken: it refuses it and offers the
/// nearest name.
class UnknownSetting : public Setting {
 public:
  static constexpr const char* last = "~";
  static constexpr std::string_view models[] = {"model", "tangential", "cohesion",
                                                "rolling_friction", "surface"};
  /// Of a fix wall/gran.
  static constexpr std::string_view wall_words[] = {
      "primitive", "mesh", "shear", "temperature", "store_force", "store_force_contact"};

  explicit UnknownSetting(const std::map<std::string, Setting*>& known) : Setting(last, 0) {
    for (const auto& [name, setting] : known) names_.push_back(name);
  }

  int parseArguments(char** words) override {
    const std::string found(words[0]);
    const auto is_one_of = [&](std::span<const std::string_view> words) {
      return std::ranges::count(words, found) > 0;
    };
    if (is_one_of(models))
      error_message = "'" + found +
                      "' comes too late: model, tangential, cohesion, rolling_friction and surface "
                      "stand in this order, in front of the models' keywords";
    else if (is_one_of(wall_words))
      error_message = "'" + found + "' has to stand in front of the contact models' keywords";
    else
      error_message = "contact models: " + unknown_keyword(found, names_);
    return -1;
  }
  void print_value(FILE*) override {}

 private:
  std::vector<std::string> names_;
};

/// To be called when all models have registered their settings.
inline void catch_unknown_settings(Settings& settings) {
  auto& known = settings.*member(detail::SettingsByName{});
  known[UnknownSetting::last] = new UnknownSetting(known);  // the settings delete it
}

}  // namespace bedload

#pragma once

#include <string>

#include "liggghts_styles/unknown_setting.hpp"

namespace bedload {

/// Makes LIGGGHTS read a keyword of a contact model that takes one of several words; `value`
/// becomes the number of the word among the choices. To be called in registerSettings.
inline void read_choice(Settings& settings, const ChoiceKeyword& keyword, int& value) {
  const std::string name(keyword.name);
  Setting*& place = (settings.*member(detail::SettingsByName{}))[name];
  if (place == nullptr) {
    auto* const choice = new EnumSetting<int>(name);  // the settings delete it
    for (std::size_t n = 0; n < keyword.choices.size(); ++n)
      choice->addOption(std::string(keyword.choices[n]), static_cast<int>(n));
    choice->setDefault(std::string(keyword.choices[keyword.preset]));
    place = choice;
  }
  static_cast<EnumSetting<int>*>(place)->registerTarget(value);
}

}  // namespace bedload

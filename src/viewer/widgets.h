// Small parts of the interface that look alike everywhere.
#pragma once

#include <string>

namespace cmpg::viewer {

void section(const char* title);
// A dim label with a value at a common place right of it.
void figure(const char* label, const std::string& value);
// The label of a field, which follows at the same place and fills the line. Returns true, so that it can stand in a condition.
bool beginField(const char* label);
// A button that looks pressed while it is the one chosen. True when clicked.
bool choiceButton(const char* label, bool chosen, float width);
// Of the item before, while the cursor rests on it.
void tip(const char* text);

} // namespace cmpg::viewer

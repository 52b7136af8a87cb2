// Small parts of the interface that look alike everywhere.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace cmpg::viewer {

void section(const char* title);
// Text that ends with dots where it does not fit, or begins with them.
std::string shortened(const std::string& text, float width);
std::string shortenedAtFront(const std::string& text, float width);
// A dim label with a value at a common place right of it, or below where it does not fit there.
void figure(const char* label, const std::string& value);
// The label of a field, which follows at the same place and fills the line; below where `chosen`, which a list shows beside its arrow, does not fit there.
// Returns true, so that it can stand in a condition.
bool beginField(const char* label, const std::string& chosen = {});
// Of buttons that fill a line: what their labels need, and of what is left as much for each.
std::vector<float> widthsOfButtons(std::span<const char* const> labels);
// A button that gives its margins up, and then the end of its label, where there is little room. True when clicked.
bool button(const char* label, float width);
// A button that looks pressed while it is the one chosen. True when clicked.
bool choiceButton(const char* label, bool chosen, float width);
// Of the item before, while the cursor rests on it.
void tip(const char* text);

} // namespace cmpg::viewer

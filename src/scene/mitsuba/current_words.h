// What only versions before 3 have, as Mitsuba 3 says it, or left out: it refuses a scene for any property that it does not know.
#pragma once

#include "scene/mitsuba/object.h"

#include <deque>

namespace cmpg {

class CurrentWords {
  public:
    explicit CurrentWords(const MitsubaDocument& document) : document_(document) {}
    // The element with children that mean the same as those of the file do here; new ones live as long as this.
    MitsubaElement of(const MitsubaElement& element);

  private:
    void bitmap(MitsubaElement& element);
    void film(MitsubaElement& element);
    void conductor(MitsubaElement& element);
    void add(MitsubaElement& element, const char* tag, const char* name, const std::string& value);

    const MitsubaDocument& document_;
    std::deque<MitsubaElement> made_;
};

} // namespace cmpg

// Parts of an HTML report that needs nothing but itself: style inside, images as data, no script.
#pragma once

#include "scene/image.h"

#include <string>
#include <vector>

namespace cmpg {

std::string escapeHtml(const std::string& text);
std::string pngDataUri(const Image& image); // linear values, as writePng takes them
std::string svgImage(const std::string& svg); // an element that holds the file: names inside one do not meet those of another

struct HtmlFigure {
    Image image;         // shown pixel by pixel where it is small
    std::string caption; // HTML
};
std::string htmlFigures(const std::vector<HtmlFigure>& figures);

struct HtmlTable {
    struct Column {
        std::string name, meaning; // plain text; the meaning shows under the pointer
    };
    std::vector<Column> columns;
    std::vector<std::vector<std::string>> rows; // HTML
};
std::string htmlTable(const HtmlTable& table);

// A page whose <main> element holds `body`, which scripts may take out to join several.
std::string htmlDocument(const std::string& title, const std::string& body);

std::string shortNumber(double value);                    // three digits; a dash where there is none
std::string withError(double value, double error);        // "12.3 &#177; 0.4"

} // namespace cmpg

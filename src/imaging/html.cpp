// Parts of an HTML report that needs nothing but itself: style inside, images as data, no script.
#include "imaging/html.h"

#include "scene/image_decode.h"

#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif; color: #1d2127; background: #f6f7f9; margin: 0; }
main { max-width: 1120px; margin: 0 auto; padding: 24px 20px 60px; }
h1 { font-size: 28px; line-height: 1.2; margin: 12px 0 8px; }
h2 { font-size: 21px; margin: 0 0 6px; }
h3 { font-size: 16px; margin: 26px 0 6px; }
section { background: #fff; border: 1px solid #dfe3e8; border-radius: 8px; padding: 20px 24px; margin: 20px 0; }
p { max-width: 78ch; margin: 8px 0; }
.lead { color: #4a525c; }
.result { font-size: 19px; border-left: 4px solid #0072b2; padding: 4px 0 4px 14px; margin: 14px 0; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; margin: 10px 0; }
th, td { padding: 6px 12px 6px 0; text-align: right; vertical-align: top; white-space: nowrap; }
th { border-bottom: 2px solid #444; font-weight: 600; }
th[title] { cursor: help; }
td { border-bottom: 1px solid #e6e9ed; }
th:first-child, td:first-child, .names th:nth-child(-n+3), .names td:nth-child(-n+3) { text-align: left; }
td small, td .how { color: #66707b; }
td .how { display: block; max-width: 28ch; white-space: normal; font-size: 12px; line-height: 1.35; }
.swatch { display: inline-block; width: 11px; height: 11px; border-radius: 2px; margin-right: 7px; }
.bad { color: #b3261e; font-weight: 600; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(196px, 1fr)); gap: 16px; margin: 10px 0; }
figure { margin: 0; }
figure img { width: 100%; height: auto; display: block; border: 1px solid #d5dae0; }
figure img.small { image-rendering: pixelated; }
figcaption { font-size: 13px; color: #4a525c; margin-top: 4px; }
.legend img { width: 256px; max-width: 100%; height: auto; }
.plot img { width: 100%; max-width: 860px; height: auto; }
details { margin: 14px 0 0; color: #333a42; font-size: 14px; }
summary { cursor: pointer; font-weight: 600; }
code { background: #eef0f3; padding: 1px 4px; border-radius: 3px; font-size: 13px; overflow-wrap: anywhere; }
)";

std::string base64(const Bytes& bytes) {
    constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto byte = [&](std::size_t k) { return i + k < bytes.size() ? std::uint32_t(bytes[i + k]) : 0u; };
        const std::uint32_t group = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (int k = 0; k < 4; ++k)
            text += i + std::size_t(k) <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

} // namespace

std::string escapeHtml(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '&')
            result += "&amp;";
        else if (c == '<')
            result += "&lt;";
        else if (c == '>')
            result += "&gt;";
        else if (c == '"')
            result += "&quot;";
        else if (static_cast<unsigned char>(c) >= 0x20)
            result += c;
    }
    return result;
}

std::string pngDataUri(const Image& image) { return "data:image/png;base64," + base64(encodePng(image)); }

std::string svgImage(const std::string& svg) {
    return "<img alt=\"\" src=\"data:image/svg+xml;base64," + base64(Bytes(svg.begin(), svg.end())) + "\">";
}

std::string htmlFigures(const std::vector<HtmlFigure>& figures) {
    constexpr int kSmall = 160; // narrower images are enlarged without blurring their texels
    std::string html = "<div class=\"figures\">\n";
    for (const HtmlFigure& figure : figures)
        html += std::string("<figure><img alt=\"\"") + (figure.image.width < kSmall ? " class=\"small\"" : "") + " src=\"" +
                pngDataUri(figure.image) + "\"><figcaption>" + figure.caption + "</figcaption></figure>\n";
    return html + "</div>\n";
}

std::string htmlTable(const HtmlTable& table) {
    std::string html = "<div class=\"scroll\"><table>\n<thead><tr>";
    for (const auto& column : table.columns)
        html += "<th" + (column.meaning.empty() ? "" : " title=\"" + escapeHtml(column.meaning) + "\"") + ">" + escapeHtml(column.name) +
                "</th>";
    html += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        html += "<tr>";
        for (const std::string& cell : row)
            html += "<td>" + cell + "</td>";
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

std::string htmlDocument(const std::string& title, const std::string& body) {
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
           escapeHtml(title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n" + body + "</main>\n</body>\n</html>\n";
}

std::string shortNumber(double value) {
    if (!std::isfinite(value))
        return "&ndash;";
    char text[32];
    std::snprintf(text, sizeof text, std::abs(value) >= 1000 && std::abs(value) < 1e6 ? "%.0f" : "%.3g", value);
    return text;
}

std::string withError(double value, double error) {
    if (!std::isfinite(value))
        return "&ndash;";
    if (!(error > 0) || !std::isfinite(error))
        return shortNumber(value);
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", error);
    return shortNumber(value) + " <small>&plusmn;&nbsp;" + text + "</small>";
}

} // namespace cmpg

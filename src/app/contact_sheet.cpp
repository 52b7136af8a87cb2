// One picture that tells how an optimisation went: target, initial, recovered, signed gradient, loss curve.
#include "app/contact_sheet.h"

#include "app/exposure.h"
#include "app/loss_curve.h"
#include "app/signed_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr int kPanel = 256, kMargin = 12, kTitle = 30, kCaption = 18;
constexpr int kStride = kPanel + kMargin, kRow = kCaption + kPanel + kSignedLegendHeight + kMargin;
constexpr std::size_t kMostRows = 6; // pictures stay a sensible size; all views are in the output folder

Image scaled(const Image& image, float factor) {
    Image result = image;
    for (float& v : result.values)
        v = std::isfinite(v) ? std::clamp(v * factor, 0.f, 1.f) : 0.f;
    return result;
}

// As many characters as fit the width of a panel.
std::string fitted(const std::string& text) {
    return text.substr(0, kPanel / Canvas::textWidth("mm") * 2);
}

void drawPicture(Canvas& canvas, int x, int y, const std::string& caption, const Image& image, float factor) {
    canvas.text(x, y, fitted(caption));
    if (!image.values.empty())
        canvas.picture(x, y + kCaption, kPanel, kPanel, scaled(image, factor));
}

void drawGradient(Canvas& canvas, int x, int y, const ContactSheet::GradientPanel& panel) {
    const Image values = channelMean(panel.gradient);
    const double scale = signedScale(values);
    canvas.text(x, y, fitted("gradient of " + panel.name));
    canvas.picture(x, y + kCaption, kPanel, kPanel, colorSigned(values, scale));
    drawSignedLegend(canvas, x, y + kCaption + kPanel + 4, kPanel, scale);
}

} // namespace

Image ContactSheet::compose() const {
    const int rows = int(std::clamp<std::size_t>(views.size(), 1, kMostRows));
    Canvas canvas(kMargin + 5 * kStride, kTitle + rows * kRow);
    canvas.text(kMargin, kMargin / 2, title, kBlack, 2);
    std::vector<const Image*> targets;
    for (const ViewRow& row : views)
        targets.push_back(&row.target);
    const float factor = exposureFor(targets);
    for (int row = 0; row < rows; ++row) {
        const int y = kTitle + row * kRow;
        if (std::size_t(row) < views.size()) {
            const ViewRow& view = views[row];
            const std::string suffix = view.name.empty() ? "" : ", " + view.name;
            drawPicture(canvas, kMargin, y, "target" + suffix, view.target, factor);
            drawPicture(canvas, kMargin + kStride, y, "initial", view.initial, factor);
            drawPicture(canvas, kMargin + 2 * kStride, y, "recovered", view.recovered, factor);
        }
        if (std::size_t(row) < gradients.size())
            drawGradient(canvas, kMargin + 3 * kStride, y, gradients[row]);
    }
    const int x = kMargin + 4 * kStride;
    canvas.text(x, kTitle, "loss");
    drawLossCurve(canvas, x, kTitle + kCaption, kPanel, kPanel, loss);
    return canvas.image();
}

} // namespace cmpg

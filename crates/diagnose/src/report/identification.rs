/// placeholder
pub struct Scatter;
/// placeholder
pub fn identification_html() {}

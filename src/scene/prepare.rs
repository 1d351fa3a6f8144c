//! stub
/// stub
pub struct PreparedScene {}

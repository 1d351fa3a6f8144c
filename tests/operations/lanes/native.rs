use octray::internal::lanes;

#[path = "operations.rs"]
mod operations;

//! Indices into the scene's lists of links, mechanisms, tracks and contact laws: each a type of its own, so that
//! none is taken for another.

macro_rules! index {
    ($(#[$meta:meta])* $name:ident) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub usize);

        impl From<usize> for $name {
            fn from(index: usize) -> Self {
                Self(index)
            }
        }

        impl From<$name> for usize {
            fn from(index: $name) -> Self {
                index.0
            }
        }
    };
}

index! {
    /// Index into `Scene::links`: one rigid body, which has a mass, a shape and features that touch.
    LinkIndex
}

index! {
    /// Index into `Scene::mechanisms`: what moves as one system of differential equations.
    MechanismIndex
}

index! {
    /// Index into `Scene::tracks`: what one tracker sees.
    TrackIndex
}

index! {
    /// Index into `Scene::contact_laws`: restitution and friction of what touches.
    ContactLawIndex
}

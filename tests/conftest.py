from hypothesis import settings

# the first call of a compiled function compiles it, which no deadline should count
settings.register_profile("default", deadline=None)
settings.load_profile("default")

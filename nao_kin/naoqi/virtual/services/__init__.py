"""The services by NAOqi's modules; `virtual_nao` joins them."""
